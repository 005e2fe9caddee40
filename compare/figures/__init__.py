"""Figures: the paper's Figs. 3 to 5 from any labelled data set, one file a figure.

May import `evaluation` and `pages`.
"""
