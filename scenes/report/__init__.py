"""Report: the recognised objects of a scan as JSON, labelled PLY, picture and interactive page.

May import `recognition`, `scans`, and the shared stack's `formats` and `viewer`.
"""
