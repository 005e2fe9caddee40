"""The fast backend: the paper's point-cloud roller (§III-A) in compiled kernels."""

from .backend import FastSimulator

__all__ = ["FastSimulator"]
