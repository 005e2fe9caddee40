"""Wares: cups, dishes, boxes, lamps, plants, devices and what else lies about, one file a family.

May import `parts`; never furniture.
"""
