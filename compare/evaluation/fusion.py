"""Several kinds of features side by side, as the paper hopes for (§IV-B): what each misses another may see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .profiled import Profiled


def fused(features: Sequence[Profiled]) -> Profiled:
    """Return the quantities of several features (N, Q1 + Q2 + ...) as one, for the classifier of the first."""
    return replace(features[0], profiles=np.hstack([feature.profiles for feature in features]))
