"""Recognition: objects of a scan are completed, spheres are dropped on them, and they are classified (paper, §IV-C).

May import `scans`, `segmentation` and the shared stack.
"""
