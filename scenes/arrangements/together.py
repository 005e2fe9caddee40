"""Several objects together, in one call: what each stands on and carries, and its functions alone and together."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spherefunc_bullet.classification import decide
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.conversion import Anything, as_cloud
from spherefunc_bullet.errors import CheckedSettings, InputError, amount, explaining, one_line, warn_renamed
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.function_model import FunctionModel, Membership
from spherefunc_bullet.learning.model_file import inference_model
from spherefunc_bullet.settling.cached_runs import CloudObject
from spherefunc_bullet.settling.drops import NOT_SETTLED, Drops, RunLimit, resting_drops, settled_in_column
from spherefunc_bullet.settling.resting_places import ACROSS, LIMITS
from spherefunc_bullet.settling.settling import DENSE, drop_settings, no_drops, too_fine
from spherefunc_bullet.simulator import DropResult, DropSettings, Outcome, Simulator, make_simulator

from .falls import ArrangedDrops, drops_over, falls_on, united, within_boxes
from .levels import ArrangedLevel, crossing, layer_of, level_of
from .placing import ArrangedObject, Placement, along_heading
from .supports import GROUND, Feet, require_carried, set_down, tips_by

if TYPE_CHECKING:
    from spherefunc_bullet.learning.classifier import CloudClassifier


def functions_among(objects: Sequence[ArrangedObject], number: int, model: FunctionModel) -> dict[str, Membership]:
    """Return the functions of one object among the others."""
    simulator = make_simulator(model.simulator)
    around, angle = along_heading(objects, number)

    def drop(run_limit: RunLimit) -> dict[float, Drops]:
        runs = [drops_for(around, number, simulator, radius, model.seed, run_limit) for radius in model.chosen_radii()]
        return {drops.radius: drops.turned(-angle) for drops in runs}

    return model.memberships_by(model.read(drop).scores[None])[0]


def drops_for(
    objects: Sequence[ArrangedObject], number: int, simulator: Simulator, radius: float, seed: int, run_limit: RunLimit
) -> Drops:
    """Return the drops of one radius in the object's own frame; those that another object carries did not settle."""
    local = objects[number].own
    if too_fine(radius, local, run_limit) or radius > local.size.max():
        return no_drops(radius, run_limit)
    falls = drops_over(objects, number, simulator, drop_settings(simulator, radius, run_limit), [seed])
    if run_limit.drops is None:
        return resting_drops(radius, objects[number].to_own(falls.centers[falls.by(number)]).astype(np.float32))
    return own_drops(falls, objects, number)


def own_drops(falls: ArrangedDrops, objects: Sequence[ArrangedObject], number: int) -> Drops:
    """Return all drops over an object in its own frame."""
    target, rows = objects[number], falls.by(number)
    around = np.concatenate([target.to_own(item.cloud.thinned(DENSE * falls.radius)) for item in objects])
    begun = np.column_stack([falls.columns, np.zeros(len(falls.columns))])
    settled = settled_in_column(target.to_own(falls.centers[rows]), around, falls.radius)
    return replace(
        settled,
        places=target.to_own(begun)[:, :2].astype(np.float32),
        outcomes=np.where(rows, np.int8(Outcome.SETTLED), np.int8(NOT_SETTLED)),
        rests=settled.rests.astype(np.float32),
        walled_in=settled.walled_in.astype(np.float32),
    )


FEWEST = 2
SPREAD = 1000  # metres across all objects at most: the drops to cover them grow with its square
SHOWN = 0.4  # of the box around all objects, that the spheres of the common drop cover


@dataclass(frozen=True, kw_only=True)
class TogetherSettings(CheckedSettings):
    """How spheres are dropped on several objects."""

    radius: float | None = amount(None, above=0.0)  # metres; None: as the objects are large
    # Over each object's box, alone and together, from which areas are measured.
    drops: int = amount(1000, least=1, most=10**7)
    seed: int = amount(0)


@dataclass(frozen=True, kw_only=True, eq=False)
class ArrangedResult:
    """One object of an arrangement: what it stands on and carries, and its functions alone and together."""

    name: str
    placed: ArrangedObject
    stands_on: tuple[str, ...]  # names of others, or the ground
    carries: np.ndarray  # (S, 3) spheres of the common drop that it carries, metres, the world's frame
    level: ArrangedLevel | None  # None where nothing rests on it
    alone: dict[str, Membership]
    together: dict[str, Membership]

    @property
    def lost(self) -> tuple[str, ...]:
        """The functions that it has alone but not among the others."""
        return tuple(
            name for name, membership in self.alone.items() if membership.member and not self.together[name].member
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Together:
    """Several objects in their places."""

    objects: tuple[ArrangedResult, ...]
    drop: DropResult  # on all of them at once, the world's frame
    radius: float  # of its spheres, metres
    notes: tuple[str, ...]  # sentences: which objects interpenetrate, which would tip
    seconds: float
    provenance: dict[str, Any] = field(default_factory=dict)

    @property
    def things(self) -> tuple[ArrangedResult, ...]:
        """The objects, under their old name."""
        warn_renamed("Together.things", "objects")
        return self.objects


def together(
    objects: Sequence[tuple[Anything, Placement]],
    *,
    model: str | Path | CloudClassifier | None = None,
    backend: str | None = None,
    settings: TogetherSettings | None = None,
    units: str = "m",
    up: str = "file",
) -> Together:
    """Drop spheres on several objects at once, and say what each carries, is for, and takes from the others.

    Parameters
    ----------
    objects : sequence of (object, Placement)
        Each object is a path, an (N, 3) array, an Open3D or trimesh object or a `Cloud`. Those without a height are set
        down in this order, each on what stands there already, or on the ground.
    model, backend
        See `classify`; spheres are dropped by the simulator that the model is for.
    settings : TogetherSettings, optional
    units, up
        See `load_cloud`; the same for all.

    Raises
    ------
    InputError
        If there are fewer than two, one cannot be used, or nothing carries it where it is put.
    """
    with explaining("expected a list of pairs (object, Placement)", TypeError, ValueError):
        objects = [(item, placement) for item, placement in objects]
    if odd := [placement for _, placement in objects if not isinstance(placement, Placement)]:
        raise InputError(f"expected a Placement for each object, got {one_line(repr(odd[0])):.80}")
    if len(objects) < FEWEST:
        raise InputError(f"expected at least two objects to stand together, got {len(objects)}")
    clouds = [as_cloud(item, units=units, up=up, name=f"object {k}") for k, (item, _) in enumerate(objects, 1)]
    placed = put_down(clouds, [placement for _, placement in objects])
    return classify_together(placed, inference_model(model, backend), settings or TogetherSettings())


def put_down(clouds: Sequence[Cloud], placements: Sequence[Placement]) -> list[ArrangedObject]:
    """Return objects in their places; those without a height are set down on what stands there already.

    Names that several have are numbered.
    """
    placed: list[ArrangedObject] = []
    count, seen = Counter(cloud.name for cloud in clouds), Counter[str]()
    for cloud, placement in zip(clouds, placements, strict=True):
        seen[cloud.name] += 1
        name = f"{cloud.name} ({seen[cloud.name]})" if count[cloud.name] > 1 else cloud.name
        item = ArrangedObject(name, cloud, placement, placement.z or 0.0)
        placed.append(item if placement.z is not None else set_down(item, placed))
    return placed


def classify_together(placed: Sequence[ArrangedObject], model: FunctionModel, settings: TogetherSettings) -> Together:
    """Drop spheres on objects in their places, and return what each of them carries and is for."""
    started = time.perf_counter()
    size = np.ptp(np.concatenate([item.cloud.bounds for item in placed]), axis=0)
    if size.max() > SPREAD:
        raise InputError(f"all together: expected objects within {SPREAD} m, got {size.max():.4g} m; are these metres?")
    feet = [require_carried(item, without(placed, k)) for k, item in enumerate(placed)]
    simulator = make_simulator(model.simulator)
    fitting = float(np.clip(size.max() / ACROSS, *LIMITS))
    radius = fitting if settings.radius is None else settings.radius
    layer = layer_of(size, radius, SHOWN)
    run = DropSettings(radius=radius, miss_limit=layer, max_drops=layer, even_columns=True)
    clouds = [item.cloud for item in placed]
    drop, falls = falls_on(clouds, united(clouds, "all together"), simulator, run, settings.seed)
    falls = within_boxes(falls, placed)
    return Together(
        objects=tuple(classify_one(placed, k, feet[k], falls, model, settings) for k in range(len(placed))),
        drop=drop,
        radius=radius,
        notes=tuple(notes_on(placed, feet)),
        seconds=time.perf_counter() - started,
        provenance=drop.provenance | {"asked": asdict(settings)},
    )


def classify_one(
    placed: Sequence[ArrangedObject],
    number: int,
    feet: Feet,
    falls: ArrangedDrops,
    model: FunctionModel,
    settings: TogetherSettings,
) -> ArrangedResult:
    """Return what one object stands on and carries, and its functions."""
    simulator = make_simulator(model.simulator)
    return ArrangedResult(
        name=placed[number].name,
        placed=placed[number],
        stands_on=feet.carriers([other.name for other in without(placed, number)]),
        carries=falls.centers[falls.by(number)],
        level=level_of(placed, number, simulator, settings.radius, settings.drops, settings.seed),
        alone=decide(CloudObject(raw_cloud=placed[number].own, drop_config=model.drop_config()), model).memberships,
        together=functions_among(placed, number, model),
    )


def without(placed: Sequence[ArrangedObject], number: int) -> list[ArrangedObject]:
    """Return all objects but one."""
    return [item for k, item in enumerate(placed) if k != number]


def notes_on(placed: Sequence[ArrangedObject], feet: Sequence[Feet]) -> list[str]:
    """Return a sentence for each pair of objects that interpenetrate and each object that would tip."""
    notes, stacks = (
        [],
        {
            item.name: (item, feet[k].carriers([other.name for other in without(placed, k)]))
            for k, item in enumerate(placed)
        },
    )
    for k, item in enumerate(placed):
        for other in placed[:k]:
            place = crossing(item, other)
            if place is not None:
                where = ", ".join(f"{number:.2f}" for number in place)
                notes.append(f"{item.name} and {other.name} interpenetrate, at {where} m")
        beyond, loads = tips_by(item, feet[k]), loads_on(item.name, stacks)
        if beyond > 0 and stacks[item.name][1] != (GROUND,):
            notes.append(f"{item.name} would tip: its weight acts {format_length(round(beyond, 3))} beyond its feet")
        elif loads and (beyond := tips_by(item, feet[k], [stacks[name][0] for name in loads])) > 0:
            under = f"would tip under {' and '.join(loads)}: their weight"
            notes.append(f"{item.name} {under} acts {format_length(round(beyond, 3))} beyond its feet")
    return notes


def loads_on(name: str, stacks: Mapping[str, tuple[ArrangedObject, tuple[str, ...]]]) -> list[str]:
    """Return the names of the objects that an object carries alone, with those that stand on them alone."""
    direct = [other for other, (_, carriers) in stacks.items() if carriers == (name,)]
    return [load for other in direct for load in (other, *loads_on(other, stacks))]
