"""Bench: how fast simulators and batches are, beside a peer in the same run.

May import the shared stack and `machine`; no test measures time, this does.
"""
