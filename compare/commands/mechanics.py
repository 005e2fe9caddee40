"""``spherefunc mechanics``: what rigid bodies tell that geometry cannot, as tasks with known answers."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spherefunc_bullet.commands.options import Json
from spherefunc_bullet.console import print_json, print_table, say
from spherefunc_bullet.errors import InputError

if TYPE_CHECKING:
    from ..mechanics.keeping import KeepScore
    from ..mechanics.poses import PoseScore
    from ..mechanics.standing import Agreement, StandScore
    from ..mechanics.tasks import Verdict

TASKS = ("poses", "standing", "keeping")


def mechanics(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder of upright objects with a manifest.")],
    backends: Annotated[str, typer.Option(help="Which are asked; what one cannot do is said.")] = "fast,bullet",
    tasks: Annotated[str, typer.Option(help="Of poses, standing and keeping.")] = ",".join(TASKS),
    count: Annotated[int | None, typer.Option(min=1, help="Objects of each task at most, evenly chosen.")] = 100,
    model: Annotated[Path | None, typer.Option(help="Which ranks poses; without one, the model that ships.")] = None,
    json: Json = False,
):
    """Measure poses found, sound furniture told from sawn, and vessels told by what they keep."""
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.learning.model_file import load_model, shipped_model
    from spherefunc_bullet.simulator import make_simulator

    chosen = tasks.split(",")
    if unknown := set(chosen) - set(TASKS):
        raise InputError(f"--tasks {', '.join(sorted(unknown))}: expected some of {', '.join(TASKS)}")
    objects = open_dataset(data).objects
    simulators = [make_simulator(name) for name in backends.split(",")]
    found: dict[str, Any] = {}
    if "poses" in chosen:
        from ..mechanics.poses import score_poses

        classifier = load_model(model or shipped_model("fast"))
        poses = [score_poses(objects, simulator, classifier, count) for simulator in simulators]
        found["poses"] = [asdict(one) for one in poses]
        None if json else print_pose_scores(poses)
    if "standing" in chosen:
        from ..mechanics.standing import agreement, score_standing

        stood = [score_standing(objects, simulator, count) for simulator in simulators]
        same = agreement(stood[0], stood[1]) if len(stood) > 1 else None
        found["standing"] = {"scores": [asdict(one.score) for one in stood], "agreement": same and asdict(same)}
        None if json else print_stand_scores(stood, same)
    if "keeping" in chosen:
        from ..mechanics.keeping import score_keeping

        able = [simulator for simulator in simulators if hasattr(simulator, "carry")]
        for simulator in simulators:
            None if simulator in able else say(f"backend {simulator.name!r} cannot carry, and is left out of keeping")
        kept = [score_keeping(objects, simulator, count) for simulator in able]
        found["keeping"] = [asdict(one) for one in kept]
        None if json else print_keep_scores(kept)
    None if not json else print_json(found)


def print_pose_scores(scores: list[PoseScore]):
    """Print how well poses are found."""
    rows = [
        [one.backend, str(one.asked), f"{one.found:.3f}", f"{one.first:.3f}", f"{one.likeliest:.3f}"]
        + [f"{one.poses:.1f}", f"{one.seconds:.3f}"]
        for one in scores
    ]
    head = ["poses", "objects", "upright found", "best for its function", "likeliest", "poses each", "median s"]
    print_table("Objects turned at random: the pose in which they are used", head, rows)
    for one in scores:
        if one.missed:
            print(f"{one.backend}, not the best: {', '.join(one.missed)}")


def print_stand_scores(scores: list[StandScore], same: Agreement | None):
    """Print how well sound furniture is told from sawn, and in how much two backends agree."""
    rows = [
        [one.score.backend, str(one.score.asked)]
        + [f"{value:.3f}" for value in (one.score.f_measure, one.score.precision, one.score.recall)]
        + [f"{one.score.cpu_seconds:.2f}"]
        for one in scores
    ]
    head = ["standing", "things", "F of sound", "precision", "recall", "processor s each"]
    print_table("\nFurniture whole, with a leg sawn off, with its legs cut askew", head, rows)
    for one in scores:
        print_wrong(one.score.backend, one.verdicts)
    if same is not None:
        print(
            f"the first two agree on {same.verdicts:.3f} of {same.things} verdicts, {same.stances:.3f} of what becomes "
            f"of them unloaded, and {same.places:.3f} of the places that carry"
        )


def print_keep_scores(scores: list[KeepScore]):
    """Print how well vessels are told by what they keep."""
    for one in scores:
        rows = [
            ["vessels", *(f"{share:.2f}" for share in one.vessels)],
            ["plates, trays, shelves, tables", *(f"{share:.2f}" for share in one.others)],
        ]
        head = ["mean share kept at", *(f"{angle:g}°" for angle in one.angles_deg)]
        print_table(f"\nKeeping, {one.score.backend}, {one.score.asked} objects", head, rows)
        told = f"F {one.score.f_measure:.3f}, precision {one.score.precision:.3f}, recall {one.score.recall:.3f}"
        print(f"half kept at {one.angles_deg[-1]:g}° is a vessel: {told}; {one.score.cpu_seconds:.2f} processor s each")
        print_wrong(one.score.backend, one.verdicts)


def print_wrong(backend: str, verdicts: tuple[Verdict, ...]):
    """Print what was told wrong."""
    wrong = [f"{one.name} ({one.value:.2f})" for one in verdicts if one.true != one.told]
    if wrong:
        print(f"{backend}, told wrong: {', '.join(wrong)}")
