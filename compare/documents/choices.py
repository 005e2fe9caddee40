"""Tables of what was chosen and what else there was: alternatives, numbers of drops, stopping, seeds, scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import Any

import numpy as np

from ..evaluation.impaired import COPIES_LEARNT, HARMLESS, HELD, UNSEEN_KIND, USELESS, Shares, mean_rows
from .paper_figures import SPHERES, Evaluated, functions_of, result_of
from .tables import FUNCTIONS, figures, table

Figures = Mapping[str, float]  # function -> F-measure
Ways = Mapping[str, Mapping[str, Figures]]  # what `spherefunc evaluate --alternatives --json` prints
NOT_RUN = ["not run: hours, since a sphere that nothing stops takes 20,000 steps", "", ""]


def side_by_side(row: Figures) -> str:
    """Return F-measures side by side."""
    return " ".join(f"{row[name]:.3f}" for name in FUNCTIONS)


def alternatives(household: Ways, models: Ways) -> list[str]:
    """Return a row for each alternative."""
    head = ["alternative", "`household`, random halves", "real models, random halves", "across sources"]
    rows = []
    for name, row in household.items():
        there = [side_by_side(each) for each in models[name].values()] if name in models else NOT_RUN
        rows.append([name, side_by_side(row["random halves"]), *there])
    return table([*head, "random halves, each object turned by a random quarter"], rows)


def limits(household: Ways, models: Ways) -> list[str]:
    """Return the alternatives that differ in when runs end, by spheres of 5 mm alone."""
    names = [name for name in household if name in ("paper", "cubes", "cubes, to the end") or "spheres at most" in name]
    names = [name for name in names if "250" not in name and "2,000" not in name]
    rows = [
        [name.removeprefix("§III-A: "), *(side_by_side(data[name]["random halves"]) for data in (household, models))]
        for name in names
    ]
    return table(["spheres of 5 mm alone", "`household`", "real models"], rows)


def one_radius(*asked: Evaluated) -> list[str]:
    """Return a row for each radius; first all of `household`, then all of the real models."""
    radii = ("5 mm", "1 cm", "2 cm", "3 cm", "5 cm")
    found = [figures(result_of(one, "random_splits")["functions"], between=" ") for one in asked]
    pairs = zip(radii, found[: len(radii)], found[len(radii) :], strict=True)
    return table(["radius", "`household`", "real models"], list(pairs))


def by_drops(profiles: Mapping[str, Any]) -> list[str]:
    """Return F-measures across sources by how many drops are read."""
    first = profiles["first"]
    return table(["drops at each radius", *first], [["F", *map(side_by_side, first.values())]])


def across_sources(profiles: Mapping[str, Any]) -> list[str]:
    """Return a row for each feature, spheres and points together the last."""
    result = result_of(profiles, "leave_one_group_out")
    rows = [
        [name.replace("_", " "), figures(functions_of(result, name), between=" ")]
        for name in (SPHERES, *result["baselines"])
    ]
    return table(["features", f"across sources ({result['train_size']})"], rows)


def reliability(profiles: Mapping[str, Any]) -> list[str]:
    """Return how often scores are true, by how high they are."""
    bins = profiles["reliability"]
    rows = [
        ["how many", *(str(row["scores"]) for row in bins)],
        ["said, in the mean", *(f"{row['said']:.3f}" for row in bins)],
        ["true", *(f"{row['true']:.3f}" for row in bins)],
    ]
    return table(["score", *(f"{row['from']:g} to {row['to']:g}" for row in bins)], rows)


def over_seeds(fast: Mapping[str, Sequence[Figures]], bullet: Mapping[str, Sequence[Figures]]) -> list[str]:
    """Return means and standard deviations over seeds by backend."""
    rows = []
    for name, printed in (("`fast`", fast), ("`bullet`", bullet)):
        columns = [[row[function] for row in printed["seeds"]] for function in FUNCTIONS]
        rows.append([name, *(f"{np.mean(column):.3f} ± {np.std(column):.3f}" for column in columns)])
    return table(["", *FUNCTIONS], rows)


def budget(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what each number of drops costs and gives, by simulator."""
    found: dict[tuple[str, int], list[str]] = {}
    for row in rows:
        cells = found.setdefault((row["backend"], row["drops"]), [f"{row['milliseconds']:.1f}"])
        cells.append(f"{row['f_measure']:.3f}")
    head = ["simulator", "drops at each radius", "ms on the median object, all radii", *FUNCTIONS]
    return table(head, [[f"`{name}`", str(drops), *cells] for (name, drops), cells in found.items()])


def stopping(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what comes of stopping early, objects and copies side by side."""
    copies = {(row["drops"], row["error"]): row for row in rows if row["objects"] == "copies"}
    shown = [
        [str(row["drops"]), f"{row['error']:g}", *stopped(row), *stopped(copies[row["drops"], row["error"]])]
        for row in rows
        if row["objects"] == "whole"
    ]
    head = ["asked after drops", "every score within"]
    for what in ("whole objects", "copies"):
        head += [f"answered early, {what}", "of these wrong", "after all drops"]
    return table(head, shown)


def stopped(row: Mapping[str, Any]) -> list[str]:
    """Return the share of objects that need no more drops, and how many of these are wrong, then and in the end."""
    return [f"{row['stopped']:.3f}", str(row["wrong"]), str(row["wrong_to_the_end"])]


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


def both_by_cubes(fast: Evaluated, bullet: Evaluated) -> list[str]:
    """Return the spheres of either backend counted in cubes, by protocol."""
    protocols = {"100 learnt": ("random_splits", 100), "random halves": ("random_splits", None)}
    protocols |= {"leave one out": ("leave_one_out", None), "across sources": ("leave_one_group_out", None)}
    rows = [
        [name, *(figures(result_of(evaluated, *protocol)["functions"]) for protocol in protocols.values())]
        for name, evaluated in (("bullet", bullet), ("fast", fast))
    ]
    return table(["", *protocols], rows)


def of_bullet(halves_and_sources: Evaluated, household: Evaluated) -> list[str]:
    """Return the spheres of `bullet` under three protocols."""
    found = {
        "spheres, random halves": result_of(halves_and_sources, "random_splits"),
        "spheres, leave one group out": result_of(halves_and_sources, "leave_one_group_out"),
        "spheres, learnt on `household`": result_of(household, "test"),
    }
    rows = [[name, *cells(result)] for name, result in found.items()]
    return table(["by `bullet`", *FUNCTIONS], rows)


def cells(result: Mapping[str, Any]) -> list[str]:
    """Return the F-measures of the spheres, the fair ones in brackets."""
    return [
        f"{row['f_measure']:.3f} ({row['f_measure_fair']:.3f})"
        for row in (result["functions"][name] for name in FUNCTIONS)
    ]


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
    """Return a row for each kind of copy."""
    shares = both_backends(fast, bullet)
    features = list(next(iter(next(iter(shares.values())).values()))["share"])
    rows: list[list[str]] = []
    for function, own in shares.items():
        for kind, row in [*own.items(), *mean_rows(own, features)]:
            rows.append(kind_row(f"{function}, {kind.replace('_', ' ')}", row, features))
    return table(["copy", "works", "copies", *(name.replace("_", " ") for name in features)], rows)


def kind_row(name: str, row: Mapping[str, Any], features: list[str]) -> list[str]:
    """Return one row; means stand out."""
    bold = f"**{name}**" if name.endswith("mean") else name
    return [
        bold,
        "yes" if row["works"] else "no",
        str(row["copies"]),
        *(f"{row['share'][name]:.2f}" for name in features),
    ]
