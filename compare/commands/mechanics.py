"""``spherefunc mechanics``: tasks with known answers, for which rigid bodies tell more than geometry."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spherefunc_bullet.commands.options import Json
from spherefunc_bullet.console import Failures, print_json, print_table, say, show

if TYPE_CHECKING:
    from ..mechanics.measures import TaskReports
    from ..mechanics.poses import KeepScore, PoseScore
    from ..mechanics.standing import ScoredAnswers


def mechanics(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder of upright objects with a manifest.")],
    backends: Annotated[
        str, typer.Option("--backends", "--backend", help="Simulators; what one cannot do is reported.")
    ] = "fast,bullet",
    tasks: Annotated[str, typer.Option(help="Some of poses, standing, keeping, places.")] = "poses,standing,keeping",
    count: Annotated[int | None, typer.Option(min=1, help="Maximum number of objects for each task.")] = 100,
    model: Annotated[Path | None, typer.Option(help="Model that ranks poses. Default: the package's model.")] = None,
    json: Json = False,
):
    """Measure how well simulators find poses, detect sawn furniture, and classify vessels by what they keep."""
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.learning.model_file import load_model, shipped_model
    from spherefunc_bullet.simulator import make_simulator

    from ..mechanics.measures import measured, read_tasks, task_reports
    from ..mechanics.standing import TaskOptions

    chosen = read_tasks(tasks.split(","))
    simulators = {name: make_simulator(name) for name in backends.split(",")}
    classifier = load_model(model or shipped_model("fast"))
    failures = Failures()
    options = TaskOptions(count=count, failed=failures.add)
    found = measured(open_dataset(data).objects, simulators, chosen, classifier, options)
    print_json(task_reports(found)) if json else print_measured(found)
    failures.exit()


def print_measured(found: TaskReports):
    """Print the results of backends for each task, and a sentence on the benefit of the more expensive backend."""
    from ..mechanics.measures import sentences

    for task, unable in found.unable.items():
        for name in unable:
            say(f"backend {name!r} cannot do this, and is left out: {task}")
    if found.poses:
        print_pose_scores(list(found.poses.values()))
    if found.standing:
        title = "Furniture whole, with a leg sawn off, with its legs cut askew: is it sound?"
        print_verdicts(title, "standing", list(found.standing.values()))
    if (same := found.agreement) is not None:
        show(
            f"the first two agree on {same.verdicts:.3f} of {same.things} verdicts, {same.stances:.3f} of what becomes "
            f"of them unloaded, and {same.places:.3f} of the places that carry"
        )
    if found.keeping:
        print_keep_scores(list(found.keeping.values()))
    if found.places:
        title = "Seats, and copies on which nobody can sit: is there a place to sit, proven where the backend can?"
        print_verdicts(title, "places", list(found.places.values()))
    show("\n" + "\n".join(sentences(found).values()))


def print_pose_scores(scores: list[PoseScore]):
    """Print the scores of poses."""
    rows = []
    for score in scores:
        shares = [f"{share:.3f}" for share in (score.found, score.first, score.likeliest)]
        rows.append([score.backend, str(score.asked), *shares, f"{score.poses:.1f}", f"{score.seconds:.3f}"])
    head = ["poses", "objects", "upright found", "best for its function", "likeliest", "poses each", "median s"]
    print_table("Objects turned at random: the pose in which they are used", head, rows)
    for score in scores:
        if missed := [name for name, right in score.right.items() if not right]:
            show(f"{score.backend}, not the best: {', '.join(missed)}")


def print_verdicts(title: str, first: str, answered: Sequence[ScoredAnswers]):
    """Print how well backends distinguish objects that work from those that do not, and the misclassified ones."""
    rows = []
    for score in (answers.score for answers in answered):
        shares = [f"{value:.3f}" for value in (score.f_measure, score.precision, score.recall)]
        rows.append([score.backend, str(score.asked), *shares, f"{score.cpu_seconds:.2f}"])
    print_table(f"\n{title}", [first, "objects", "F", "precision", "recall", "processor s each"], rows)
    for answers in answered:
        print_wrong(answers)


def print_keep_scores(scores: list[KeepScore]):
    """Print the scores of keeping, with the mean curves."""
    for keeping in scores:
        score, curves = keeping.score, {"vessels": keeping.vessels, "plates, trays, shelves, tables": keeping.others}
        curves |= {f"vessels, {holed.kind.replace('_', ' ')} %": holed.kept for holed in keeping.holed}
        rows = [[what, *(f"{share:.2f}" for share in curve)] for what, curve in curves.items()]
        head = ["mean share kept at", *(f"{angle:g}°" for angle in keeping.angles_deg)]
        print_table(f"\nKeeping, {score.backend}, {score.asked} objects", head, rows)
        for holed in keeping.holed:
            still = f"{round(holed.classified * holed.asked)} of {holed.asked}"
            show(f"{holed.kind.replace('_', ' ')} % of the depth: {still} still classified as vessels")
        quality = f"F {score.f_measure:.3f}, precision {score.precision:.3f}, recall {score.recall:.3f}"
        rule = f"half kept at {keeping.angles_deg[-1]:g}° is a vessel"
        show(f"{rule}: {quality}; {score.cpu_seconds:.2f} processor s each")
        print_wrong(keeping)


def print_wrong(answers: ScoredAnswers):
    """Print the objects that were misclassified."""
    wrong = [f"{answer.name} ({answer.value:.2f})" for answer in answers.verdicts if answer.true != answer.positive]
    if wrong:
        show(f"{answers.score.backend}, misclassified: {', '.join(wrong)}")
