"""Tables from the JSON of `spherefunc evaluate`: features, the paper's Figs. 3 and 4 next to ours, and copies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from statistics import fmean
from typing import Any

from spherefunc_bullet.formats.units import format_length

from ..evaluation.features import SPHERES
from ..evaluation.impaired import COPIES_LEARNT, HARMLESS, HELD, UNSEEN_KIND, USELESS, Shares, mean_rows, share_rows
from ..evaluation.protocol import PAPER
from .tables import FUNCTIONS, figures, table

Evaluated = Mapping[str, Any]  # the JSON of `spherefunc evaluate`


def result_of(evaluated: Evaluated, protocol: str, size: int | None = None) -> Mapping[str, Any]:
    """Return the result of one protocol at a training size, by default the largest."""
    found = [result for result in evaluated["results"] if result["protocol"] == protocol]
    return next(result for result in reversed(found) if size in (None, result["train_size"]))


def functions_of(result: Mapping[str, Any], feature: str) -> Mapping[str, Any]:
    """Return the figures of each function by one feature."""
    return result["functions"] if feature == SPHERES else result["baselines"][feature]


def by_feature(protocol: str) -> Callable[[Evaluated], list[str]]:
    """Return a function that makes a table of all features, with fair F-measures in brackets."""

    def lines(evaluated: Evaluated) -> list[str]:
        result = result_of(evaluated, protocol)
        head = [f"{protocol.replace('_', ' ')}, {result['train_size']:,} training objects", *FUNCTIONS]
        return table(head, [feature_row(result, feature) for feature in (SPHERES, *result["baselines"])])

    return lines


def feature_row(result: Mapping[str, Any], feature: str, name: str = "") -> list[str]:
    """Return the row of one feature."""
    row = functions_of(result, feature)
    cells = [f"{row[name]['f_measure']:.3f} ({row[name]['f_measure_fair']:.3f})" for name in FUNCTIONS]
    return [name or feature.replace("_", " "), *cells]


OWN = {  # names of features in the two tables of README
    "points": "the object's own points, same quantities",
    "rules": "rules on height, area, flatness",
    "examiner": "examiner, a person of boxes and a ball",
}


def six_catalogues(fast: Evaluated, bullet: Evaluated) -> list[str]:
    """Return all features, learnt from the catalogues that the models of the package learn."""
    result = result_of(fast, "test")
    rows = [feature_row(result, SPHERES, "spheres by `fast`")]
    rows.append(feature_row(result_of(bullet, "test"), SPHERES, "spheres by `bullet`"))
    rows += [feature_row(result, feature) for feature in result["baselines"]]
    return table([f"test, {result['train_size']:,} training objects", *FUNCTIONS], rows)


def overview(*data_sets: Evaluated) -> list[str]:
    """Return README's table: features by training data.

    Parameters
    ----------
    data_sets : of real models, household to them, six catalogues to them by `fast`, by `bullet`; two of those by cubes
    """
    fast, bullet, cubes = data_sets[:3], data_sets[3:6], data_sets[6:]
    features = list(fast[0]["results"][-1]["baselines"])
    rows = [
        ["**spheres by `fast`**", *overview_row(fast, SPHERES)],
        ["**spheres by `bullet`**", *overview_row(bullet, SPHERES)],
        ["spheres by `fast`, `--method cubes`", *overview_row(cubes, SPHERES), ""],
        *([OWN.get(feature, feature.replace("_", " ")), *overview_row(fast, feature)] for feature in features),
        ["the paper, on its authors' 200 models", " / ".join(f"{PAPER[name]:.2f}" for name in FUNCTIONS), "", "", ""],
    ]
    learnt = ("a random half", "all but one source, each in turn", "`household` alone")
    head = [f"learnt: {what}" for what in (*learnt, "six made-up catalogues, as what ships")]
    return table(["features", *head], rows)


def overview_row(data_sets: tuple[Evaluated, ...], feature: str) -> list[str]:
    """Return the F-measures of one feature: by two protocols on the first data, and tested after learning others."""
    results = [result_of(data_sets[0], "random_splits"), result_of(data_sets[0], "leave_one_group_out")]
    results += [result_of(evaluated, "test") for evaluated in data_sets[1:]]
    return [figures(functions_of(result, feature)) for result in results]


# Fig. 3 on its authors' 200 models: radius, F-measure, accuracy.
FIG_3 = {"cup": ("0.5 cm", "0.80", "0.96"), "table": ("1 cm", "0.85", "0.94"), "sittable": ("0.5 cm", "0.74", "0.92")}
COLUMNS = ("cup", "table", "sittable", "none")  # of Fig. 4, its rows likewise
SIZES = (20, 45, 85)
# Fig. 4, one trial of 100 objects: rows of the confusion matrix by training size.
FIG_4 = {
    20: ("10, 0, 0, 6", "0, 20, 0, 2", "1, 0, 6, 15", "2, 8, 0, 33"),
    45: ("11, 0, 0, 5", "0, 18, 0, 4", "1, 3, 13, 6", "1, 2, 3, 34"),
    85: ("12, 0, 0, 4", "0, 21, 0, 1", "1, 2, 18, 1", "2, 3, 6, 29"),
}
# Computed from Fig. 4: F-measures of cup, sittable, table; the column "none"; the excess of a matrix over 100.
F_OF_FIG_4 = {20: "0.69, 0.43, 0.80", 45: "0.76, 0.68, 0.80", 85: "0.77, 0.78, 0.88"}
NONE_OF_FIG_4, SEVERAL_OF_FIG_4 = "56, 49, 35 of 100", "3, 1, 0 of 100"


def fig_3(household: Evaluated, models: Evaluated) -> list[str]:
    """Return Fig. 3: how well each function is classified, with the radius that most trials chose."""
    rows = []
    for name, (radius, f_measure, accuracy) in FIG_3.items():
        rows.append([name, "the paper", radius, f_measure, accuracy, "", ""])
        for data, evaluated in (("`household`", household), ("real models", models)):
            row = result_of(evaluated, "random_splits")["functions"][name]
            shown = [f"{row[key]:.3f}" for key in ("f_measure", "accuracy", "precision", "recall")]
            rows.append(["", data, format_length(row["radius"]), *shown])
    return table(["", "data", "radius", "F-measure", "accuracy", "precision", "recall"], rows)


def fig_4(household: Evaluated, models: Evaluated) -> list[str]:
    """Return Fig. 4: confusion matrices, means of ten trials."""
    rows = []
    for size in SIZES:
        for label, matrix in zip(COLUMNS, FIG_4[size], strict=True):
            ours = [confusion_row(result, size, label) for result in (household, models)]
            rows.append([str(size) if label == "cup" else "", label, matrix, *ours])
    return table(["training", "labelled", f"the paper: {', '.join(COLUMNS)}", "`household`", "real models"], rows)


def confusion_row(evaluated: Evaluated, size: int, label: str) -> str:
    """Return the row of one label in the confusion matrix, the mean of the trials."""
    result = result_of(evaluated, "random_splits", size)
    row = result["said"]["confusion"][label]
    return ", ".join(f"{row[name] / result['trials']:.1f}" for name in COLUMNS)


def memberships(household: Evaluated, models: Evaluated) -> list[str]:
    """Return the figures that follow from Fig. 4."""
    both, rows = (household, models), []
    for size in SIZES:
        cells = [figures(result_of(result, "random_splits", size)["functions"], between=", ") for result in both]
        words = f": F of {', '.join(FUNCTIONS)}" if size == SIZES[0] else ""
        rows.append([f"{size}{words}", F_OF_FIG_4[size], *cells])
    without = "no predicted memberships at 20, 45, 85, of those tested"
    rows.append([without, NONE_OF_FIG_4, *(counts(result, "none") for result in both)])
    rows.append(["several memberships", SEVERAL_OF_FIG_4, *(counts(result, "several") for result in both)])
    left = [left_out(result_of(result, "leave_one_out")["said"]) for result in both]
    rows.append(["left out one by one: no membership, several", "not given", *left])
    return table(["", "the paper", "`household`", "real models"], rows)


def counts(evaluated: Evaluated, name: str) -> str:
    """Return the number of objects with no membership, or with several, by training size."""
    results = [result_of(evaluated, "random_splits", size) for size in SIZES]
    means = ", ".join(f"{result['said']['memberships'][name] / result['trials']:.1f}" for result in results)
    return f"{means} of {results[0]['said']['tested'] / results[0]['trials']:g}"


def left_out(confusion: Mapping[str, Any]) -> str:
    """Return the numbers of objects with no membership and with several, each object left out once."""
    return f"{confusion['memberships']['none']}, {confusion['memberships']['several']} of {confusion['tested']}"


def by_size(fast: Evaluated, bullet: Evaluated, cubes: Evaluated) -> list[str]:
    """Return F-measures on random halves by the number of training objects."""

    def by_size_of(evaluated: Evaluated) -> dict[int, str]:
        results = [result for result in evaluated["results"] if result["protocol"] == "random_splits"]
        return {result["train_size"]: figures(result["functions"], between=" ") for result in results}

    sizes, rows = list(by_size_of(fast)), []
    by_feature = {"spheres by `fast`": fast, "spheres by `bullet`": bullet, "spheres, cubes (below)": cubes}
    for name, evaluated in by_feature.items():
        known = by_size_of(evaluated)
        rows.append([name, *(known.get(size, "") for size in sizes)])
    return table(["features", *(f"{size} training objects" for size in sizes)], rows)


def cubes_and_paper(paper: Evaluated, cubes: Evaluated) -> list[str]:
    """Return the methods `cubes` and `paper` by protocol."""
    rows = [["the paper's own data, as published", "Fig. 3b does not say", "paper", "0.80", "0.74", "0.85"]]
    largest = [(protocol, None) for protocol in ("random_splits", "leave_one_out", "leave_one_group_out")]
    for protocol, size in (("random_splits", 100), *largest):
        for name, evaluated in (("paper", paper), ("cubes", cubes)):
            result = result_of(evaluated, protocol, size)
            cells = [f"{result['functions'][function]['f_measure']:.3f}" for function in FUNCTIONS]
            rows.append([protocol.replace("_", " "), str(result["train_size"]), name, *cells])
    return table(["protocol", "training objects", "method", *FUNCTIONS], rows)


BY_BULLET = f"{SPHERES} by `bullet`"
ENDINGS = ("", COPIES_LEARNT, COPIES_LEARNT + UNSEEN_KIND, HELD)  # of the names of the spheres' columns, in this order


def both_backends(fast: Evaluated, bullet: Evaluated) -> Shares:
    """Return the shares of all features, the spheres of `bullet` after those of `fast`."""
    return {
        function: {
            kind: row | {"share": joined(row["share"], bullet["impaired"][function][kind]["share"])}
            for kind, row in kinds.items()
        }
        for function, kinds in fast["impaired"].items()
    }


def joined(fast: Mapping[str, float], bullet: Mapping[str, float]) -> dict[str, float]:
    """Return the shares of one kind: spheres by either backend first, then all baselines."""
    shares = {SPHERES + ending: fast[SPHERES + ending] for ending in ENDINGS}
    shares |= {BY_BULLET + ending: bullet[SPHERES + ending] for ending in ENDINGS}
    return shares | {name: share for name, share in fast.items() if name not in shares}


def means(fast: Evaluated, bullet: Evaluated) -> list[str]:
    """Return a row for each feature: the shares of useless and harmless copies still classified by the function."""
    shares, cells = both_backends(fast, bullet), {}
    for function in FUNCTIONS:
        features = list(next(iter(shares[function].values()))["share"])
        rows = dict(mean_rows(shares[function], features))
        for feature in features:
            useless, harmless = (rows[which]["share"][feature] for which in (USELESS, HARMLESS))
            cells.setdefault(feature, []).append(f"{useless:.2f} / {harmless:.2f}")
    return table(["", *FUNCTIONS], [[name.replace("_", " "), *row] for name, row in cells.items()])


def unseen_kinds(evaluated: Evaluated) -> list[str]:
    """Return a row for each way to learn: useless copies classified as useful, on average and of the worst kind."""
    cells: dict[str, list[str]] = {}
    for function in FUNCTIONS:
        rows = [row for kind, row in evaluated["impaired"][function].items() if kind != "whole"]
        read = [name for name in rows[0]["share"] if name.startswith((SPHERES, "points"))]
        for feature in (name for name in read if not name.endswith(HELD)):
            useless = [row["share"][feature] for row in rows if not row["works"]]
            harmless = [row["share"][feature] for row in rows if row["works"]]
            shares = fmean(useless), max(useless), fmean(harmless)
            cells.setdefault(feature, []).append(" / ".join(f"{share:.2f}" for share in shares))
    return table(["", *FUNCTIONS], [[name, *row] for name, row in cells.items()])


def kinds(fast: Evaluated, bullet: Evaluated) -> list[str]:
    """Return a row for each kind of copy; means stand out."""
    head, rows = share_rows(both_backends(fast, bullet))
    return table(head, [[f"**{name}**" if name.endswith("mean") else name, *row] for name, *row in rows])
