"""Resting profiles, and models that are asked by them: what answering takes, without scikit-learn."""
