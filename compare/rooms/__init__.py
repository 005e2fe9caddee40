"""Rooms: how well scans are segmented and labelled, of virtual rooms with ground truth and of real ones (§IV-C).

May import `pages`, `scenes` and the shared stack.
"""
