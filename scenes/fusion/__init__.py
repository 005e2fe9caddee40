"""Fusion: depth images over time as one map, whose objects keep their ids.

`frames` reads depth images and poses, `grid` fuses them into a truncated signed distance and keeps a small view of
each, `tracking` estimates missing poses and gives known objects their ids, and `scene_fusion` is the whole in one
class.
"""
