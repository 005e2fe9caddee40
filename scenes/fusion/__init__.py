"""Fusion: depth images over time as one map, whose objects keep their ids.

`frames` reads depth images and poses, `point_map` fuses them into points and keeps a small view of each image,
`changes` says which part of the map has to be looked at again, `tracking` estimates missing poses and gives known
objects their ids, and `scene_fusion` is the whole in one class.
"""
