"""Robustness: how objects of sources that were not learnt are classified in use, and as sensors give them."""
