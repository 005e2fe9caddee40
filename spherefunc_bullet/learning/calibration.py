"""From a classifier's votes to probabilities, so that 0.5 means what it says (Platt, 1999)."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, logit
from sklearn.base import ClassifierMixin, clone
from sklearn.model_selection import StratifiedKFold, cross_val_predict

FOLDS = 3  # of the cross-validation whose votes are looked at
SURE = 0.01  # votes beyond this are as good as unanimous: a forest of 300 trees cannot tell them apart
STIFFNESS = 3.0  # nats that an e-fold change of the slope or of the odds costs; least log loss over training sizes
Line = tuple[float, float]  # slope, and what is added to the log odds
AS_VOTED: Line = (1.0, 0.0)


def held_out_votes(estimator: ClassifierMixin, X: np.ndarray, members: np.ndarray, random_state: int) -> np.ndarray:
    """Return what a classifier says of each of its training objects (N,) when it has not learnt them.

    Parameters
    ----------
    X : (N, D) float
    members : (N,) bool
        At least two of either kind.
    """
    folds = min(FOLDS, int(members.sum()), int((~members).sum()))
    splits = StratifiedKFold(folds, shuffle=True, random_state=random_state)
    return cross_val_predict(clone(estimator), X, members, cv=splits, method="predict_proba")[:, 1]


def calibration_line(votes: np.ndarray, members: np.ndarray) -> Line:
    """Return the line through log odds that makes held-out votes (N,) the likeliest for members (N,) bool.

    We differ from Platt in that leaving votes as they are costs nothing, and any change does: few examples
    change little.
    """
    odds, signs = log_odds(votes), np.where(members, 1.0, -1.0)

    def cost(line: np.ndarray) -> float:
        slope, offset = line
        misses = np.logaddexp(0, -signs * (np.exp(slope) * odds + offset)).sum()
        return float(misses + STIFFNESS * (slope**2 + offset**2))

    slope, offset = minimize(cost, [0.0, 0.0], method="BFGS").x
    return float(np.exp(slope)), float(offset)


def calibrated(votes: np.ndarray, line: Line) -> np.ndarray:
    """Return probabilities (N,) from votes (N,)."""
    slope, offset = line
    return expit(slope * log_odds(votes) + offset)


def log_odds(votes: np.ndarray) -> np.ndarray:
    """Return the logarithm of the odds of votes from 0 to 1, the unanimous brought to finite ones."""
    return logit(np.clip(votes, SURE, 1 - SURE))
