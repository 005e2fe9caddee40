"""Comparison: every simulator on the same objects, accuracy against cost, in tables, charts and one page.

May import `evaluation` and `pages`.
"""
