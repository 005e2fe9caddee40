"""Recognition: objects of a scan completed, dropped on, and told what they are for (paper, §IV-C, Fig. 6).

May import `scans`, `segmentation` and the shared stack.
"""
