"""Evaluation: the paper's protocol on one data set, with baselines that need no spheres (§IV-B).

May import the shared stack; everything else in `compare` builds on it.
"""
