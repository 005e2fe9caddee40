"""Tables of how well functions are classified, from the JSON of `spherefunc evaluate`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .markdown import FUNCTIONS, figures, table

Evaluated = Mapping[str, Any]  # what `spherefunc evaluate --json` prints
SPHERES = "spheres"
PAPER = {"cup": 0.80, "sittable": 0.74, "table": 0.85}  # F-measures of Fig. 3, on its authors' 200 models


def result_of(evaluated: Evaluated, protocol: str, size: int | None = None) -> Mapping[str, Any]:
    """Return one protocol's figures; of several training sizes the largest, or the one that is named."""
    found = [one for one in evaluated["results"] if one["protocol"] == protocol]
    return next(one for one in reversed(found) if size in (None, one["train_size"]))


def functions_of(result: Mapping[str, Any], feature: str) -> Mapping[str, Any]:
    """Return the figures of each function by one feature."""
    return result["functions"] if feature == SPHERES else result["baselines"][feature]


def by_feature(protocol: str, size: int | None = None, title: str = "") -> Callable[[Evaluated], list[str]]:
    """Return what makes a table of all features, F-measures with the fair ones in brackets."""

    def lines(evaluated: Evaluated) -> list[str]:
        result = result_of(evaluated, protocol, size)
        head = [f"{title or protocol.replace('_', ' ')}, {result['train_size']:,} training objects", *FUNCTIONS]
        return table(head, [feature_row(result, feature) for feature in (SPHERES, *result["baselines"])])

    return lines


def feature_row(result: Mapping[str, Any], feature: str, name: str = "") -> list[str]:
    """Return the row of one feature."""
    row = functions_of(result, feature)
    cells = [f"{row[name]['f_measure']:.3f} ({row[name]['f_measure_fair']:.3f})" for name in FUNCTIONS]
    return [name or feature.replace("_", " "), *cells]


OWN = {  # what the two tables of README call features
    "points": "the object's own points, same quantities",
    "rules": "rules on height, area, flatness",
    "examiner": "examiner, a person of boxes and a ball",
}


def six_catalogues(fast: Evaluated, bullet: Evaluated) -> list[str]:
    """Return all features, learnt from the catalogues of which the models that ship are made."""
    results = [result_of(evaluated, "test") for evaluated in (fast, bullet)]
    rows = [
        feature_row(result, SPHERES, f"spheres by `{name}`")
        for name, result in zip(("fast", "bullet"), results, strict=True)
    ]
    rows += [feature_row(results[0], feature) for feature in results[0]["baselines"]]
    return table([f"test, {results[0]['train_size']:,} training objects", *FUNCTIONS], rows)


def overview(*asked: Evaluated) -> list[str]:
    """Return README's table: features by what was learnt.

    Parameters
    ----------
    asked : of real models, household to them, six catalogues to them by `fast`, by `bullet`; two of those by cubes
    """
    fast, bullet, cubes = asked[:3], asked[3:6], asked[6:]
    features = list(fast[0]["results"][-1]["baselines"])
    rows = [
        ["**spheres by `fast`**", *overview_row(fast, SPHERES)],
        ["**spheres by `bullet`**", *overview_row(bullet, SPHERES)],
        ["spheres by `fast`, `--method cubes`", *overview_row(cubes, SPHERES), ""],
        *([OWN.get(feature, feature.replace("_", " ")), *overview_row(fast, feature)] for feature in features),
        ["the paper, on its authors' 200 models", " / ".join(f"{PAPER[name]:.2f}" for name in FUNCTIONS), "", "", ""],
    ]
    learnt = (
        "a random half",
        "all but one source, each in turn",
        "`household` alone",
        "six made-up catalogues, as what ships",
    )
    return table(["features", *(f"learnt: {what}" for what in learnt)], rows)


def overview_row(asked: tuple[Evaluated, ...], feature: str) -> list[str]:
    """Return the F-measures of one feature: of two protocols on the first data, and where others are learnt."""
    results = [result_of(asked[0], "random_splits"), result_of(asked[0], "leave_one_group_out")]
    results += [result_of(evaluated, "test") for evaluated in asked[1:]]
    return [figures(functions_of(result, feature)) for result in results]
