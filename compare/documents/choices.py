"""Tables of labels: by how much is learnt, by cubes, by `bullet`, and of impaired copies."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import fmean

from ..evaluation.impaired import COPIES_LEARNT, HARMLESS, HELD, UNSEEN_KIND, USELESS, Shares, mean_rows, share_rows
from .paper_figures import SPHERES, Evaluated, result_of
from .tables import FUNCTIONS, figures, table


def by_size(fast: Evaluated, bullet: Evaluated, cubes: Evaluated) -> list[str]:
    """Return F-measures on random halves by how many objects are learnt."""
    sizes = [one["train_size"] for one in fast["results"] if one["protocol"] == "random_splits"]
    rows = []
    for name, evaluated in (
        ("spheres by `fast`", fast),
        ("spheres by `bullet`", bullet),
        ("spheres, cubes (below)", cubes),
    ):
        known = {one["train_size"] for one in evaluated["results"] if one["protocol"] == "random_splits"}
        row = [
            figures(result_of(evaluated, "random_splits", size)["functions"], between=" ") if size in known else ""
            for size in sizes
        ]
        rows.append([name, *row])
    return table(["features", *(f"{size} training objects" for size in sizes)], rows)


def cubes_and_paper(paper: Evaluated, cubes: Evaluated) -> list[str]:
    """Return cubes beside the paper to the letter, by protocol."""
    rows = [["the paper's own data, as published", "Fig. 3b does not say", "paper", "0.80", "0.74", "0.85"]]
    for protocol, size in (
        ("random_splits", 100),
        ("random_splits", None),
        ("leave_one_out", None),
        ("leave_one_group_out", None),
    ):
        for name, evaluated in (("paper", paper), ("cubes", cubes)):
            result = result_of(evaluated, protocol, size)
            cells = [f"{result['functions'][function]['f_measure']:.3f}" for function in FUNCTIONS]
            rows.append([protocol.replace("_", " "), str(result["train_size"]), name, *cells])
    return table(["protocol", "training objects", "method", *FUNCTIONS], rows)


BY_BULLET = f"{SPHERES} by `bullet`"
LATER = (COPIES_LEARNT, COPIES_LEARNT + UNSEEN_KIND, HELD)  # behind the spheres, in this order


def both_backends(fast: Evaluated, bullet: Evaluated) -> Shares:
    """Return the shares of all features, the spheres of `bullet` after those of `fast`."""
    return {
        function: {
            kind: row | {"share": joined(row["share"], shares_in(bullet, function, kind))}
            for kind, row in kinds.items()
        }
        for function, kinds in fast["impaired"].items()
    }


def shares_in(evaluated: Evaluated, function: str, kind: str) -> Mapping[str, float]:
    """Return what each feature says of one kind of copy."""
    return evaluated["impaired"][function][kind]["share"]


def joined(fast: Mapping[str, float], bullet: Mapping[str, float]) -> dict[str, float]:
    """Return the shares of one kind: spheres first, by either backend, then all that needs none."""
    own = {SPHERES + behind: SPHERES + behind for behind in ("", *LATER)}
    other = {SPHERES + behind: BY_BULLET + behind for behind in ("", *LATER)}
    shares = {new: fast[old] for old, new in own.items()} | {new: bullet[old] for old, new in other.items()}
    return shares | {name: share for name, share in fast.items() if name not in shares}


def means(fast: Evaluated, bullet: Evaluated) -> list[str]:
    """Return a row for each feature: the share of useless and harmless copies that are still called by the function."""
    shares, cells = both_backends(fast, bullet), {}
    for function in FUNCTIONS:
        features = list(next(iter(shares[function].values()))["share"])
        rows = dict(mean_rows(shares[function], features))
        for feature in features:
            useless, harmless = (rows[which]["share"][feature] for which in (USELESS, HARMLESS))
            cells.setdefault(feature, []).append(f"{useless:.2f} / {harmless:.2f}")
    return table(["", *FUNCTIONS], [[name.replace("_", " "), *row] for name, row in cells.items()])


def unseen_kinds(evaluated: Evaluated) -> list[str]:
    """Return a row for each way to learn: useless copies still called useful, in the mean and of the worst kind."""
    cells: dict[str, list[str]] = {}
    for function in FUNCTIONS:
        own = evaluated["impaired"][function].values()
        for feature in (name for name in next(iter(own))["share"] if name.startswith((SPHERES, "points"))):
            if feature.endswith(HELD):
                continue
            useless = [row["share"][feature] for row in own if not row["works"]]
            harmless = [row["share"][feature] for row in own if row["works"]]
            shares = fmean(useless), max(useless), fmean(harmless)
            cells.setdefault(feature, []).append(" / ".join(f"{share:.2f}" for share in shares))
    return table(["", *FUNCTIONS], [[name, *row] for name, row in cells.items()])


def kinds(fast: Evaluated, bullet: Evaluated) -> list[str]:
    """Return a row for each kind of copy; means stand out."""
    head, rows = share_rows(both_backends(fast, bullet))
    return table(head, [[f"**{name}**" if name.endswith("mean") else name, *row] for name, *row in rows])
