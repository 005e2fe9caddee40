"""Wares: cups, containers, lamps, plants, devices, fixtures and belongings, one file for each family.

May import `parts`; never furniture.
"""
