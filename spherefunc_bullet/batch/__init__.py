"""Batch: long, resumable runs over data sets, on one machine or many, and data sets simulated by them.

May import `settling`, `datasets`, `processes` and the layers below, but not `learning`.
"""
