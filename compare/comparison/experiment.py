"""An experiment as data: simulators, objects and settings in a small TOML file that repeats it exactly."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from spherefunc_bullet.datasets.catalogue import catalogue_entry_points
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import BY_FILE, parse_lengths
from spherefunc_bullet.learning.method import PROFILE, PROFILE_RADII, find_method
from spherefunc_bullet.settling.cached_runs import DropConfig, LoadOptions
from spherefunc_bullet.settling.drops import LIMITED, RunLimit
from spherefunc_bullet.simulator import make_simulator

from ..mechanics.measures import TASKS, read_tasks

ALL = "all"  # the key of the radii of every backend without its own
CUBES_RADII = (0.02, 0.03, 0.05)  # metres: the quick ones of full runs
BACKENDS = ("fast", "bullet")
LABELS = "labels"  # the task that every comparison measures
COPIED = 4  # objects of each function by default
Kind = TypeVar("Kind")


@dataclass(frozen=True, kw_only=True)
class ComparedSimulator(DropConfig):
    """One simulator in the comparison, and how it drops spheres."""

    name: str  # in the tables: the backend, and its shape where several are compared
    backend: str

    @property
    def drop_config(self) -> DropConfig:
        """How it drops spheres alone, for which worker processes need not load the comparison: a second each."""
        return DropConfig(**{each.name: getattr(self, each.name) for each in fields(DropConfig)})


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """What is compared, on what, and how."""

    data: str
    backends: tuple[str, ...]
    shapes: tuple[str, ...] = ()  # for backends that have such an option
    radii: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # metres, by backend or ALL; else the method's
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # of the simulators, by backend
    methods: tuple[str, ...] = (PROFILE,)
    tasks: tuple[str, ...] = (LABELS,)  # besides labels, of `mechanics.measures`
    task_objects: int = 100  # of each of those tasks, at most
    copied: int = 0  # objects of each function with impaired copies
    seeds: tuple[int, int] = (0, 1)  # of the spheres and the splits; of the repeated runs
    trials: int = 10
    repeated: int | None = None  # objects repeated with the second seed; None: all if that is cheap, else some
    miss_limit: int | None = None  # misses in a row that end a run; None: as in the paper
    up: str = BY_FILE
    units: str = "m"

    @property
    def loading(self) -> LoadOptions:
        return LoadOptions(up=self.up, units=self.units)

    @property
    def run_limit(self) -> RunLimit:
        """The length of runs; all methods read the same spheres."""
        run_limit = find_method(PROFILE).run_limit if PROFILE in self.methods else LIMITED
        return run_limit.ending(self.miss_limit)


def candidates(experiment: Experiment) -> list[ComparedSimulator]:
    """Return the simulators that an experiment compares.

    Raises
    ------
    InputError
        If a backend is unknown or not installed, or an option is given for a backend that is not compared or does not
        have it.
    """
    made = [candidate for backend in experiment.backends for candidate in shapes_of(experiment, backend)]
    names = {name for candidate in made for name in (candidate.name, candidate.backend)}
    for what, keys in (("radii", set(experiment.radii) - {ALL}), ("options", set(experiment.options))):
        if unknown := sorted(keys - names):
            raise InputError(f"{what}: expected some of {', '.join(sorted(names))}; got {', '.join(unknown)}")
    if experiment.shapes and not any("shape" in candidate.simulator.options() for candidate in made):
        raise InputError(f"shapes: none of {', '.join(experiment.backends)} has the option shape")
    return made


def shapes_of(experiment: Experiment, backend: str) -> list[ComparedSimulator]:
    """Return a backend with each shape, with the one of its name (``bullet:mesh``), or once if it has no shapes."""
    given, (backend, _, own_shape) = backend, backend.partition(":")
    options = experiment.options.get(backend, {})
    usual = PROFILE_RADII if PROFILE in experiment.methods else CUBES_RADII
    radii = {ALL: usual} | dict(experiment.radii)
    how = {"seed": experiment.seeds[0], "loading": experiment.loading, "run_limit": experiment.run_limit}

    def named(name: str, **shape: str) -> ComparedSimulator:
        simulator, own = make_simulator(backend, **options | shape), radii.get(name) or radii.get(backend) or radii[ALL]
        return ComparedSimulator(name=name, backend=backend, simulator=simulator, radii=own, **how)

    if own_shape:
        return [named(given, shape=own_shape)]
    plain = named(backend)
    if not experiment.shapes or "shape" not in plain.simulator.options():
        return [plain]
    several = len(experiment.shapes) > 1
    return [named(f"{backend} {shape}" if several else backend, shape=shape) for shape in experiment.shapes]


def parse_radii(texts: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """Return radii in metres by backend from texts such as ``2cm,3cm`` or ``fast=1cm,2cm``.

    Raises
    ------
    InputError
        If one is no list of lengths, or two are for the same.

    Examples
    --------
    >>> parse_radii(["2cm,3cm", "fast=1cm"])
    {'all': (0.02, 0.03), 'fast': (0.01,)}
    """
    radii: dict[str, tuple[float, ...]] = {}
    for text in texts:
        name, given, lengths = text.rpartition("=")
        key = name.strip() if given else ALL
        if key in radii:
            raise InputError(f"--radii {text}: expected radii for {key} once, got them twice")
        radii[key] = parse_lengths(lengths)
    return radii


def read_experiment(path: Path) -> Experiment:
    """Read an experiment; its folder of data may be next to the file.

    Raises
    ------
    InputError
        If the file cannot be read or is no TOML, or a key is unknown, missing or of another kind.
    """
    try:
        given = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: expected an experiment in TOML; {error}") from error
    if unknown := sorted(set(given) - set(KEYS)):
        raise InputError(f"{path}: expected the keys {', '.join(KEYS)}; got {', '.join(unknown)}")
    if missing := [name for name in ("data", "backends") if name not in given]:
        raise InputError(f"{path}: expected the keys data and backends; {', '.join(missing)} missing")
    values = {}
    for name, value in given.items():
        read, kind = KEYS[name]
        try:
            values[name] = read(value)
        except (TypeError, ValueError, AttributeError) as error:
            reason = f"; {error}" if isinstance(error, InputError) else ""
            raise InputError(f"{path}: {name}: expected {kind}, got {value!r}{reason}") from error
    beside = path.parent / values["data"]
    if beside.exists() or values["data"] not in catalogue_entry_points():
        values["data"] = str(beside)
    return Experiment(**values)


def text(value: object) -> str:
    """Return a text that is not empty."""
    if not isinstance(value, str) or not value:
        raise ValueError
    return value


def texts(value: object) -> tuple[str, ...]:
    """Return a list of different texts."""
    listed = tuple(map(text, require(value, list)))
    if not listed or len(set(listed)) < len(listed):
        raise ValueError
    return listed


def whole(value: object, least: int = 1) -> int:
    """Return a whole number that is not too small."""
    if isinstance(value, bool) or require(value, int) < least:
        raise ValueError
    return value


def require(value: object, kind: type[Kind]) -> Kind:
    """Return a value if it is of a type."""
    if not isinstance(value, kind):
        raise TypeError
    return value


def read_radii(value: object) -> dict[str, tuple[float, ...]]:
    """Return radii in metres by backend, from a table of lists or one list for all."""
    lists = value.items() if isinstance(value, dict) else [(ALL, value)]
    return {name: parse_lengths(",".join(map(str, require(lengths, list)))) for name, lengths in lists}


def read_options(value: object) -> dict[str, dict[str, Any]]:
    """Return simulators' options by backend."""
    return {name: require(options, dict) for name, options in require(value, dict).items()}


def read_seeds(value: object) -> tuple[int, int]:
    """Return two different seeds; if only one is given, the second is the next number."""
    seeds = tuple(whole(seed, 0) for seed in require(value, list))
    if not 1 <= len(set(seeds)) == len(seeds) <= 2:
        raise ValueError
    return (seeds[0], seeds[-1] if len(seeds) == 2 else seeds[0] + 1)


def read_methods(value: object) -> tuple[str, ...]:
    """Return the names of known methods, all of which can read the same spheres."""
    named = tuple(find_method(name).name for name in texts(value))
    if PROFILE in named and len(named) > 1:
        raise InputError(f"methods {', '.join(named)}: expected {PROFILE} alone, which reads runs of its own")
    return named


def read_options_of(value: object) -> tuple[str, ...]:
    """Return the names of tasks, with labels among them."""
    named = read_tasks(texts(value), (LABELS, *TASKS))
    if LABELS not in named:
        others = ",".join(named)
        raise InputError(f"expected {LABELS} among them; `spherefunc mechanics --tasks {others}` measures the others")
    return named


KEYS: dict[str, tuple[Callable[[object], Any], str]] = {  # the function that reads a value, and the expected value
    "data": (text, "a folder or a catalogue's name"),
    "backends": (texts, "a list of names"),
    "shapes": (texts, "a list of names"),
    "radii": (read_radii, "a list of lengths, or a table of such lists by backend"),
    "options": (read_options, "a table of tables by backend"),
    "methods": (read_methods, "a list of names"),
    "tasks": (read_options_of, f"a list of tasks, {LABELS} among them"),
    "task_objects": (whole, "a whole number from 1"),
    "seeds": (read_seeds, "two whole numbers from 0, the second for what is dropped again"),
    "trials": (whole, "a whole number from 1"),
    "copied": (partial(whole, least=0), "a whole number from 0"),
    "repeated": (whole, "a whole number from 1"),
    "miss_limit": (whole, "a whole number from 1"),
    "up": (text, "z, y, x, auto or file"),
    "units": (text, "m, cm, mm, in or auto"),
}


def as_toml(experiment: Experiment) -> str:
    """Return an experiment as TOML that `read_experiment` reads; lengths in metres."""
    values = {name: value for name, value in asdict(experiment).items() if value not in (None, (), {})}
    return "".join(f"{name} = {toml_value(value)}\n" for name, value in values.items())


def toml_value(value: object) -> str:
    """Return a value as TOML.

    Examples
    --------
    >>> toml_value({"bullet voxel": (0.02, 0.03), "on": True})
    '{"bullet voxel" = [0.02, 0.03], "on" = true}'
    """
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    # TOML writes texts, numbers and booleans as JSON does.
    return json.dumps(value, ensure_ascii=False)
