"""What says the same whatever it has seen: scores that nothing was learnt for, under the paper's protocol."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.learning.method import CUBES
from spherefunc_bullet.settling.records import ObjectRecord

from ..evaluation import Evaluation, Trial
from ..features import of_each
from ..protocol import Labels, Split, Splits
from .examiner import examined
from .rules import functions_by_rules

Classify = Callable[[ObjectRecord], frozenset[str]]  # the functions that an object has
RELATED: dict[str, Classify] = {"rules": functions_by_rules, "examiner": examined}


@dataclass(frozen=True, kw_only=True, eq=False)
class Fixed:
    """All objects' scores, which no training changes."""

    scores: np.ndarray  # (N, F) float, 0 or 1
    labels: Labels

    def trial(self, splits: Sequence[Split]) -> Trial:
        """Return what is said of the objects that splits test."""
        rows = np.concatenate([split.test for split in splits])
        learnt = round(float(np.mean([len(split.train) for split in splits])))
        return Trial(learnt=learnt, rows=rows, scores=self.scores[rows], weights=())

    def trials(self, asked: Sequence[Sequence[Split]]) -> list[Trial]:
        """Return several trials."""
        return [self.trial(splits) for splits in asked]

    def evaluation(self, splits: Splits) -> Evaluation:
        """Return what was said of the objects under a protocol, of the same ones as others are tested on."""
        return Evaluation(
            labels=self.labels,
            method=CUBES,
            trials={size: self.trials([[split] for split in trials]) for size, trials in splits.halves.items()},
            left_out={name: self.trial(alone) for name, alone in splits.left_out.items()},
        )


def related(records: Sequence[ObjectRecord], labels: Labels) -> dict[str, Fixed]:
    """Return what the baselines of related work say of objects; functions that they do not know score 0."""
    return {name: fixed(classify, records, labels) for name, classify in RELATED.items()}


def fixed(classify: Classify, records: Sequence[ObjectRecord], labels: Labels) -> Fixed:
    """Return one baseline's scores of objects."""
    said = of_each(classify, records)
    scores = [[float(function in functions) for function in labels.functions] for functions in said]
    return Fixed(scores=np.array(scores).reshape(len(records), len(labels.functions)), labels=labels)
