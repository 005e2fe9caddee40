"""Fusion: depth images over time as one map, whose objects keep their ids.

Depth images with poses (`frames`, or `odometry` where poses are missing) go into a truncated signed distance (`grid`);
what each image shows again is kept small (`views`); `tracking` gives known objects their ids, `scene_fusion` is the
whole in one class.
"""
