"""Whether answers stay the same when an object is turned, is moved, and is met by other spheres.

    python -m spherefunc_bullet.compare.evaluation.robustness.steadiness DATA... [--backend bullet] [--model MODEL]

Each object is classified several times: as it is, and then at a random heading and place, with other seeds.
"""

from __future__ import annotations

from copy import copy
from typing import Annotated, Any

import numpy as np
import typer

from spherefunc_bullet.answer import Answer, classify
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.conversion import as_cloud
from spherefunc_bullet.clouds.preparation import turned
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run
from spherefunc_bullet.datasets.dataset import joined_datasets, open_dataset
from spherefunc_bullet.errors import InputError, require_known
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.model_file import load_model
from spherefunc_bullet.simulator import generator_of

FAR = 10.0  # metres: largest distance by which an object is moved
Row = dict[str, Any]


def moved(cloud: Cloud, random: np.random.Generator) -> Cloud:
    """Return an object at a random heading and place; a mesh is sampled anew there."""
    angle, place = random.uniform(0, 2 * np.pi), [*random.uniform(-FAR, FAR, 2), 0.0]
    if cloud.mesh is None:
        return as_cloud(turned(cloud.points, angle) + place, name=cloud.name)
    return as_cloud((turned(cloud.mesh.vertices, angle) + place, cloud.mesh.faces), name=cloud.name)


def repeated(cloud: Cloud, model: CloudClassifier, times: int) -> list[Answer]:
    """Return the answers about an object: as it is, and then moved, each with another seed."""
    random, answers = generator_of(0), []
    for seed in range(times):
        reseeded = copy(model)
        reseeded.seed = model.seed + seed
        answers.append(classify(moved(cloud, random) if seed else cloud, model=reseeded, explain=False))
    return answers


def row_of(file: str, answers: list[Answer]) -> Row:
    """Return how much the answers about one object differ."""
    sure = {answer.functions for answer in answers if not answer.unsure}
    scores = np.array([list(answer.scores.values()) for answer in answers])
    return {
        "file": file,
        "answers": sorted({", ".join(sorted(answer.functions)) or "none" for answer in answers}),
        "changes": len({answer.functions for answer in answers}) > 1,
        "sure_change": len(sure) > 1,
        "unsure": float(np.mean([answer.unsure for answer in answers])),
        "deviation": float(scores.std(axis=0).max()),
    }


def summary(rows: list[Row]) -> Row:
    """Return how many objects have answers that change, and the deviation of their scores in the mean."""
    return {
        "objects": len(rows),
        "changes": sum(row["changes"] for row in rows),
        "sure_change": sum(row["sure_change"] for row in rows),
        "unsure": round(float(np.mean([row["unsure"] for row in rows])), 4),
        "deviation": round(float(np.mean([row["deviation"] for row in rows])), 4),
    }


def main(
    data: Annotated[list[str], typer.Argument(help="Data sets, best those that the model has not learnt.")],
    times: Annotated[int, typer.Option(min=2, help="How often each object is classified.")] = 8,
    backend: options.Backend = "fast",
    model: options.Model = None,
    json: options.Json = False,
):
    """Classify each object several times, turned, moved and with other seeds, and compare the answers."""
    failures, trained = Failures(), load_model(model, backend)
    dataset = joined_datasets([open_dataset(name) for name in data])
    require_known(f"{dataset.name}: label", dataset.functions, trained.functions_)
    rows = []
    for item in progress(dataset.objects, len(dataset), "classifying"):
        try:
            rows.append(row_of(item.path.name, repeated(as_cloud(item.path), trained, times)))
        except InputError as error:
            failures.add(error)
    if not rows:
        failures.exit()
        raise InputError(f"{dataset.name}: expected objects, got none")
    if json:
        print_json(summary(rows) | {"rows": rows})
    else:
        titles = ["objects", "answer changes", "sure answer changes", "unsure", "deviation of scores"]
        print_table(f"each object {times} times: turned, moved, other seeds", titles, [list(summary(rows).values())])
        changing = [[row["file"], " / ".join(row["answers"]), row["sure_change"]] for row in rows if row["changes"]]
        print_table("\nanswers that change", ["file", "answers", "sure"], changing)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
