"""``spherefunc classify --any-pose``: for each function the pose in which an object serves best."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..console import Failures, print_json, print_table
from .options import run_on_files
from .poses import posed_file

if TYPE_CHECKING:
    from ..function_model import FunctionModel
    from ..learning.any_pose import PoseFunctions

Row = dict[str, Any]


def classify_any_pose(files: Sequence[Path], classifier: FunctionModel, units: str, json: bool):
    """Print what each file's object is for in its best pose: by drops of the object where the model's backend can."""
    from ..simulator import make_simulator
    from ..simulator.mechanics import PoseSettings, require_ability

    simulator = require_ability(make_simulator(classifier.simulator), "poses")
    failures, rows, how = Failures(), [], (classifier, PoseSettings(), classifier.seed, units)
    for file, results in run_on_files(posed_file, files, simulator, how, "classifying", failures):
        _, result, answers, seconds = results
        row = {"file": str(file), "functions": best_functions(answers), "notes": list(result.notes)}
        rows.append(row | {"seconds": round(seconds, 3)})
    print_json(rows) if json else print_best(rows, classifier.functions_)
    failures.exit()


def best_functions(answers: Sequence[PoseFunctions]) -> Row:
    """Return for each function its score in the best pose, and that pose."""
    from ..learning.any_pose import best_poses

    best = {}
    for name, number in best_poses(answers).items():
        pose, membership = answers[number].pose, answers[number].functions[name]
        best[name] = {
            "member": membership.member,
            "score": membership.score,
            "radius": membership.radius,
            "rotation": pose.rotation.round(9).tolist(),
            "probability": round(pose.probability, 6),
        }
    return best


def print_best(rows: Sequence[Row], functions: Sequence[str]):
    """Print a line for each object: what it is for, turned so."""
    table = []
    for row in rows:
        members = [name for name in functions if row["functions"][name]["member"]]
        scores = [f"{row['functions'][name]['score']:.2f}" for name in functions]
        table.append([Path(row["file"]).name, ", ".join(members) or "none", *scores])
    title = "What objects are for in their best pose (`spherefunc poses` shows it)"
    print_table(title, ["file", "for", *functions], table)
