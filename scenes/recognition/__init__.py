"""Recognition: objects of a scan completed, dropped on, and classified (paper, §IV-C, Fig. 6).

May import `scans`, `segmentation` and the shared stack.
"""
