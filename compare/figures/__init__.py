"""Figures: the paper's Figs. 1 to 5 from any labelled data set, from the evaluation of its objects.

May import `evaluation` and `pages`.
"""
