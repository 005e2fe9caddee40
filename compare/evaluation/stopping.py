"""How many objects need no more than the first drops, and what labels lose by stopping there; measured across sources.

    python -m spherefunc_bullet.compare.evaluation.stopping DATA [--copied 14]

A classifier of the first few drops is asked first; where each of its scores is next to 0 or 1 and nothing is doubtful,
its answer stands, and that of all drops elsewhere: what `ProfileModel.read` does with `EARLY_DROPS` and `SURE`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated

import numpy as np
import typer
from joblib import Parallel, delayed

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, run
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.method import PROFILE
from spherefunc_bullet.learning.validation import THRESHOLD, quality
from spherefunc_bullet.settling.drops import EARLY_DROPS, first_drops

from .impaired import Impaired, held_out, impaired_copies
from .protocol import Labels, Split, labels_of, leave_one_group_out

ERRORS = (0.02, 0.05, 0.1)  # how far from 0 or 1 a score may be to be sure


@dataclass(frozen=True, kw_only=True)
class Stopping:
    """What comes of stopping after so many drops where every score is so near 0 or 1."""

    objects: str  # which were asked
    drops: int  # at each radius
    error: float  # that a score may state at most
    stopped: float  # share of the objects
    wrong: int  # of these, whose functions are not all right
    wrong_to_the_end: int  # of the same objects, after all drops
    f_measures: dict[str, float]  # of all objects, those that go on included


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """What is said of objects early and late."""

    rows: np.ndarray  # (T,) which objects
    early: np.ndarray  # (T, F) scores after the first drops
    late: np.ndarray  # (T, F) and after all
    doubtful: np.ndarray  # (T,) bool, whether the early answer says so itself


def asked_of(simulated: Simulated, split: Split, originals: Sequence[str], model: FunctionClassifier) -> Asked:
    """Return what is said of the objects that a split tests, by what it learns."""
    settled, names = simulated.settled, [str(row) for row in range(len(simulated.objects))]
    sets = [item.functions for item in simulated.objects]
    learnt = [[part[row] for row in split.train] for part in (settled, sets, names, originals)]
    model.fit_settled(*learnt)
    tested = [settled[row] for row in split.test]
    few = [first_drops(one, model.early_drops) for one in tested]
    readings = [model.early_.reading_of(one) for one in few]
    early = np.array([reading.scores for reading in readings])
    doubtful = np.array([bool(model.early_.doubts(reading)) for reading in readings])
    return Asked(rows=split.test, early=early, late=model.score_settled(tested), doubtful=doubtful)


def asked_across(
    simulated: Simulated, splits: Sequence[Split], originals: Sequence[str], model: FunctionClassifier
) -> Asked:
    """Return what is said under all splits, on all cores."""
    parts = Parallel(n_jobs=-1)(delayed(asked_of)(simulated, split, originals, model) for split in splits)
    fields = ("rows", "early", "late", "doubtful")
    return Asked(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in fields})


def stopped_at(objects: str, asked: Asked, labels: Labels, drops: int, error: float) -> Stopping:
    """Return what comes of early scores that stand where they are sure, and of late ones elsewhere."""
    members = labels.members[asked.rows]
    sure = (np.minimum(asked.early, 1 - asked.early) < error).all(axis=1) & ~asked.doubtful
    said = np.where(sure[:, None], asked.early, asked.late) > THRESHOLD
    wrong = [int(((scores > THRESHOLD) != members)[sure].any(axis=1).sum()) for scores in (asked.early, asked.late)]
    columns = zip(labels.functions, members.T, said.T, strict=True)
    return Stopping(
        objects=objects,
        drops=drops,
        error=error,
        stopped=round(float(sure.mean()), 3),
        wrong=wrong[0],
        wrong_to_the_end=wrong[1],
        f_measures={name: round(quality(has, positive).f_measure, 4) for name, has, positive in columns},
    )


def stoppings(simulated: Simulated, impaired: Impaired | None, model: FunctionClassifier) -> list[Stopping]:
    """Return what comes of stopping with each error that may be stated, of whole objects and of impaired copies."""
    drops, labels = model.early_drops, labels_of(simulated)
    asked = asked_across(simulated, leave_one_group_out(labels.groups), [""] * len(labels), model)
    rows = [stopped_at("whole", asked, labels, drops, error) for error in ERRORS]
    if impaired is not None:
        splits = [impaired.with_copies(split) for split in held_out(impaired, 0)]
        originals = [""] * impaired.whole + [str(row) for row in impaired.originals]
        asked = asked_across(impaired.simulated, splits, originals, model)
        rows += [stopped_at("copies", asked, impaired.labels, drops, error) for error in ERRORS]
    return rows


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv that names sources.")],
    counts: Annotated[str, typer.Option(help="Drops at each radius after which to stop.")] = str(EARLY_DROPS),
    copied: Annotated[int, typer.Option(help="Also ask impaired copies of so many objects of each function.")] = 0,
    backend: options.Backend = "fast",
    jobs: options.Jobs = -1,
    json: options.Json = False,
):
    """Print how many objects need no more than a few drops, and what labels lose by stopping there."""
    failures = Failures()
    dropping, dataset = options.dropping(backend, None, None, 0, "z", "m", PROFILE), open_dataset(data)
    simulated = simulate_dataset(dataset, dropping, jobs=jobs, failed=failures.add)
    how = {"copied": copied, "jobs": jobs, "failed": failures.add}
    impaired = impaired_copies([simulated], dataset, [dropping], **how)[0] if copied else None
    models = [FunctionClassifier(radii=dropping.radii, early_drops=int(count)) for count in counts.split(",")]
    rows = [row for model in models for row in stoppings(simulated, impaired, model)]
    if json:
        print_json([asdict(row) for row in rows])
    else:
        table = [
            [row.objects, str(row.drops), f"{row.error:g}", f"{row.stopped:.3f}"]
            + [str(row.wrong), str(row.wrong_to_the_end)]
            + [f"{value:.3f}" for value in row.f_measures.values()]
            for row in rows
        ]
        head = ["asked", "drops", "error", "stopped", "wrong", "wrong after all"]
        head += [f"F {name}" for name in rows[0].f_measures]
        print_table(f"{simulated.name}, {backend}: stopping where every score is sure, across sources", head, table)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
