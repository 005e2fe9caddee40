"""Bench: the speed of simulators, answers and scans, next to peers in the same run.

May import the shared stack and `machine`; tests do not measure time.
"""
