"""Figures: the paper's Figs. 1 to 5 from any labelled data set, one file a figure.

May import `evaluation` and `pages`.
"""
