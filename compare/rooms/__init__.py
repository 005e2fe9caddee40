"""Rooms: how well scans are taken apart and labelled, virtual rooms with their truth and real ones (§IV-C).

May import `pages`, `scenes` and the shared stack.
"""
