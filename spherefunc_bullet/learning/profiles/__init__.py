"""Resting profiles, and models that classify objects by them: all that inference needs, without scikit-learn."""
