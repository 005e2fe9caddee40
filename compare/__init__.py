"""Experiments and reports: the paper's evaluation, baselines, pictures, benchmarks."""
