"""``spherefunc poses``: the stable poses of objects, their probabilities, and the functions in each or the best."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, say, shown_names
from ..errors import blaming
from . import options

if TYPE_CHECKING:
    from ..clouds.cloud import Cloud
    from ..function_model import FunctionModel
    from ..learning.any_pose import PoseFunctions
    from ..simulator import Simulator
    from ..simulator.mechanics import PoseResult, PoseSettings

Row = dict[str, Any]  # JSON entry of one file, or of one pose


def poses(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", readable=False, help="Models or scans, in any pose.")
    ],
    backend: Annotated[str, typer.Option(help="bullet drops the object itself; fast computes statics.")] = "bullet",
    drops: Annotated[int, typer.Option(min=1, help="Number of times that the object is dropped.")] = 100,
    fall: Annotated[
        float, typer.Option(min=0, help="Height of the fall, relative to the object's largest extent.")
    ] = 0.1,
    mass: options.Mass = None,
    area_density: options.AreaDensity = 5.0,
    friction: options.Friction = 0.5,
    restitution: options.Restitution = 0.0,
    model: options.Model = None,
    seed: options.Seed = 0,
    units: options.Units = "m",
    package_path: options.PackagePath = None,
    picture: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw each object as it lies.")] = None,
    page: Annotated[
        Path | None, typer.Option(metavar="HTML", help="Write pictures and tables as an HTML page.")
    ] = None,
    json: options.Json = False,
):
    """Find the stable poses of each object, their probabilities, and its functions in each."""
    from ..learning.model_file import inference_model, shipped_model
    from ..simulator.mechanics import PoseSettings, require_ability
    from ..viewer.mechanics_pictures import poses_picture, write_picture, write_poses_page

    options.require_drawings(files, picture, page)
    simulator = require_ability(backend, "poses")
    matter = options.matter_of(mass, area_density, friction, restitution)
    settings = PoseSettings(drops=drops, fall=fall, matter=matter)
    classifier = inference_model(model or shipped_model("fast"), None)
    failures, how = Failures(), (classifier, settings, seed, units)
    results = options.run_on_files(posed_file, files, simulator, how, "posing", failures, bool(picture or page))
    rows = [row_of(file, *posed) for file, (_, *posed) in results]
    shown = [(cloud, answers) for _, (cloud, _, answers, _) in results if answers]
    if picture is not None and shown:
        write_picture(poses_picture(shown), picture)
    if page is not None and shown:
        write_poses_page(shown, page)
    print_json(rows) if json else print_poses(rows, classifier.functions_)
    failures.exit()


def posed_file(
    file: Path, simulator: Simulator, classifier: FunctionModel, settings: PoseSettings, seed: int, units: str
) -> tuple[Cloud, PoseResult, list[PoseFunctions], float]:
    """Return the cloud of a file, its poses, the functions in each, and the seconds that this took."""
    from ..clouds.cloud import load_cloud
    from ..learning.any_pose import pose_functions

    started = time.perf_counter()
    cloud = load_cloud(file, up="z", units=units, report=say_but_up)  # rotations are from the file's own frame
    with blaming(f"{cloud.name}: backend {simulator.name!r}"):
        result = simulator.poses(cloud, settings, seed)
    return cloud, result, pose_functions(cloud, result.poses, classifier), time.perf_counter() - started


def say_but_up(line: str):
    """Print what is reported about a file, but not which axis may be up: all are tried."""
    if " up, " not in line:
        say(line)


def row_of(file: Path, result: PoseResult, answers: Sequence[PoseFunctions], seconds: float) -> Row:
    """Return the JSON entry of one file."""
    from ..learning.any_pose import best_poses

    return {
        "file": str(file),
        "poses": [pose_row(answer) for answer in answers],
        "best": best_poses(answers),
        "drops": result.drops,
        "timed_out": result.timed_out,
        "notes": list(result.notes),
        "seconds": round(seconds, 3),
        "provenance": result.provenance,
    }


def pose_row(one: PoseFunctions) -> Row:
    """Return the JSON entry of one pose."""
    return {
        "rotation": one.pose.rotation.round(9).tolist(),
        "probability": round(one.pose.probability, 6),
        "statics": round(one.pose.statics, 6),
        "tilt_deg": round(one.pose.tilt_deg, 2),
        "functions": {name: {"member": about.member, "score": about.score} for name, about in one.functions.items()},
    }


def print_poses(rows: Sequence[Row], functions: Sequence[str]):
    """Print every pose of every object as a line."""
    table, shown = [], shown_names(row["file"] for row in rows)
    for row in rows:
        name = shown[row["file"]]
        options.say_notes(name, row["notes"])
        if row["timed_out"]:
            say(f"{name}: {row['timed_out']} of {row['drops']} drops never came to rest")
        for number, pose in enumerate(row["poses"]):
            start = ["" if number else name, f"{pose['tilt_deg']:.0f}°"]
            shares = [f"{pose[key]:.3f}" for key in ("probability", "statics")]
            table.append([*start, *shares, *function_cells(pose["functions"])])
    head = ["file", "turned by", "probability", "by statics", "for", *functions]
    print_table("How objects can lie, and what they are for in each pose (positive if > 0.5)", head, table)


def function_cells(answers: Row) -> list[str]:
    """Return table cells for the functions of an object: those that it has, then the score of each."""
    members = [name for name, about in answers.items() if about["member"]]
    return [", ".join(members) or "none", *(f"{about['score']:.2f}" for about in answers.values())]


def classify_any_pose(files: Sequence[Path], classifier: FunctionModel, units: str, json: bool, jobs: int = 1):
    """Print the best pose of each object for each function; bullet finds poses by drops, others by statics."""
    from ..simulator.mechanics import PoseSettings, require_ability

    simulator = require_ability(classifier.simulator, "poses")
    failures, rows, how = Failures(), [], (classifier, PoseSettings(), classifier.seed, units)
    posed_files = options.run_on_files(posed_file, files, simulator, how, "classifying", failures, False, jobs)
    for file, posed in posed_files:
        _, result, answers, seconds = posed
        row = {"file": str(file), "functions": best_functions(answers), "notes": list(result.notes)}
        rows.append(row | {"seconds": round(seconds, 3)})
    if json:
        print_json(rows)
    else:
        shown = shown_names(row["file"] for row in rows)
        table = [[shown[row["file"]], *function_cells(row["functions"])] for row in rows]
        title = "What objects are for in their best pose (`spherefunc poses` shows it)"
        print_table(title, ["file", "for", *classifier.functions_], table)
    failures.exit()


def best_functions(answers: Sequence[PoseFunctions]) -> Row:
    """Return the score of each function in its best pose, and that pose."""
    from ..learning.any_pose import best_poses

    best = {}
    for name, number in best_poses(answers).items():
        pose, membership = answers[number].pose, answers[number].functions[name]
        turned = {"rotation": pose.rotation.round(9).tolist(), "probability": round(pose.probability, 6)}
        best[name] = asdict(membership) | turned
    return best
