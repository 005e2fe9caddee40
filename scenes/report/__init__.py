"""Report: what was recognised in a scan, as JSON, labelled PLY, picture and page.

May import `recognition`, `scans`, and the shared stack's `formats` and `viewer`.
"""
