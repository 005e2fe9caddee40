"""Batch: long runs over data sets that lose nothing, on one machine or many, and data sets simulated by them.

May import `settling`, `datasets`, `processes` and what lies below; never learning, to which it only hands spheres.
"""
