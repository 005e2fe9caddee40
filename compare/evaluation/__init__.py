"""Evaluation: the paper's protocol on one data set, with baselines that need no spheres (§IV-B).

May import the shared stack; everything else in `compare` builds on it.
"""

TRAIN_SIZES = "20,45,85,half"  # training examples; of these, those that fit
