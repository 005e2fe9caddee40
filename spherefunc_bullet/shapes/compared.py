"""Comparison of shapes in one call, ``sf.compare_shapes``, and the search for the cheapest that keeps everything."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from ..clouds.cloud import Cloud
from ..clouds.conversion import Anything, as_cloud, geometry_of
from ..clouds.orientation import Report, promised_up, to_metres, to_z_up
from ..errors import InputError, one_line, require_amount
from ..formats.sources import Geometry, joined_meshes
from ..formats.units import BY_FILE
from ..simulator.mechanics import Material
from ..simulator.statics.body import body_of
from .candidates import MISSING, Make, candidates, has_vhacd, make_solid, of_hull, of_mesh
from .comparison import LARGER, KeepCriteria, ShapeRow, Subject, relative_size, row_of, with_verdict
from .exposure import Fitting
from .files import write_shape
from .loaded import USD, FileFrame, load_solids, no_report
from .solid import MOST_CORNERS, Solid, capped, of_pieces, surface

SCALES = (2.0, 1.2, 0.8, 0.5)  # of the tolerances, the coarsest first
BUDGET = 30.0  # seconds of processor time (so a busy machine finds the same) after which no candidate is started
STRICT = KeepCriteria(share=0.95, moved=0.002)
SAYS_COLLISION = (".urdf", ".sdf", ".xml", ".mjcf", *USD)  # formats with collision geometry
Tried = tuple[Solid, ShapeRow]


def best_shape(subject: Subject, criteria: KeepCriteria, still: bool = False, compared: Iterable[Tried] = ()) -> Tried:
    """Return the cheapest candidate that keeps everything, with its row; if none does, the one that keeps most.

    The cost is the measured time of a step with spheres in contact. The first candidate of each kind that keeps
    everything is taken, since the finer ones that follow cost more. No spheres are dropped on candidates that lose
    water, level or openings. For an object that is ``still``, the concave mesh is a candidate as well.

    Parameters
    ----------
    compared : iterable of (Solid, ShapeRow)
        Shapes measured before. Those of pieces that were fully measured are candidates as well: a compound, which has
        hundreds, only if no other keeps everything.
    """
    until, tried = time.process_time() + BUDGET, []

    def enough() -> bool:
        return time.process_time() > until

    for kind in kinds(subject, enough, still):
        for name, make in kind:
            if tried and enough():
                break
            solid = make_solid(name, make)
            tried.append((solid, row_of(subject, solid, criteria, early=True)))
            if tried[-1][1].keeps:
                break
        if tried[-1][1].keeps and [len(piece) <= MOST_CORNERS for piece in tried[-1][0].pieces or ()] == [True]:
            break  # nothing is cheaper than one convex piece of few corners
    judged = [(one, with_verdict(row, subject, criteria)) for one, row in compared if row.measured and one.pieces]
    tried += [one for one in judged if one[0].name != "compound"]
    if not any(row.keeps for _, row in tried):
        tried += [one for one in judged if one[0].name == "compound"]
    solid, row = min(tried, key=costs)
    return (solid, row) if row.measured else (solid, row_of(subject, solid, criteria))


def costs(tried: Tried) -> tuple[float, ...]:
    """Return what the best shape has the least of; no step is timed of one on which no spheres rest, such as a ball."""
    solid, row = tried
    step = row.step_us if np.isfinite(row.step_us) else np.inf
    return not row.keeps, shortfall(row), step, len(solid.vertices)


def kinds(subject: Subject, enough: Callable[[], bool], still: bool) -> Iterator[list[tuple[str, Make]]]:
    """Yield the candidates of each kind, by name, the coarsest first."""
    if still:
        yield [("mesh", partial(of_mesh, subject.cloud))]
    yield [("hull", partial(blunt_hull, subject)), ("hull", partial(of_hull, subject.cloud))]
    fitting = Fitting(subject, enough)
    yield [(f"fitted {scale:g}", partial(fitting.pieces, scale)) for scale in SCALES]


def blunt_hull(subject: Subject) -> Solid:
    """Return the convex hull with at most `MOST_CORNERS` corners; a scan's has thousands."""
    hull = of_hull(subject.cloud)
    return hull if len(hull.vertices) <= MOST_CORNERS else of_pieces("hull", [capped(hull.vertices)])


def shortfall(row: ShapeRow) -> float:
    """Return how far a shape is from keeping everything; 0 if it does."""
    if row.keeps:
        return 0.0
    shares = (row.level_kept, row.settled_kept, row.capacity_kept)
    return 1 - min(share for share in shares if share is not None) + 0.05 * row.openings_closed


@dataclass(frozen=True, kw_only=True, eq=False)
class BestShape:
    """The cheapest shape that keeps everything, ready to be written."""

    row: ShapeRow
    solid: Solid
    subject: Subject
    frame: FileFrame

    @property
    def name(self) -> str:
        return self.row.name

    def write(self, path: str | Path, form: str | None = None, matter: Material | None = None) -> Path:
        """Write the shape as URDF, SDF or MJCF (.xml), with its meshes in a folder next to it; return the path.

        It is in metres, z up, about the origin of the object's own file, so that it can replace that file.
        """
        body, back = body_of(self.subject.cloud, matter or Material()), -self.frame.shift
        body = replace(body, center=body.center + back, corners=body.corners + back)
        return write_shape(Path(path), self.subject.mesh.shifted(back), self.solid.shifted(back), body, form)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shapes:
    """The comparison of an object with several shapes, one row for each."""

    subject: Subject
    rows: tuple[ShapeRow, ...]
    solids: tuple[Solid, ...]  # the shape of each row
    frame: FileFrame
    kept: KeepCriteria
    keep: float | None  # the requested share; None: `best` keeps what `STRICT` requires

    def __iter__(self):
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    @cached_property
    def best(self) -> BestShape:
        """The cheapest shape of convex pieces that keeps everything, found on first access, within a minute."""
        return self.best_for()

    def best_for(self, still: bool = False) -> BestShape:
        """Return the cheapest shape that keeps everything; for a static object it may be the concave mesh."""
        compared = list(zip(self.solids, self.rows, strict=True))
        solid, row = best_shape(self.subject, self.kept if self.keep else STRICT, still, compared)
        return BestShape(row=row, solid=solid, subject=self.subject, frame=self.frame)

    def as_dict(self, file: str) -> dict[str, Any]:
        """Return the comparison, JSON-ready."""
        return {
            "file": file,
            "functions": functions_dict(self.subject.functions),
            "capacity_ml": round(1e6 * self.subject.capacity, 1) if self.subject.is_vessel else 0.0,
            "level_mm": round(1e3 * self.subject.level.height, 1),
            "seed_spread": round(self.subject.seen.spread, 3),
            "keep": self.kept.share,
            "shapes": [as_row(row) for row in self.rows],
        }


def functions_dict(functions: dict[str, tuple[bool, float]]) -> dict[str, dict[str, Any]]:
    """Return functions, JSON-ready, as all commands print them."""
    return {name: {"member": member, "score": score} for name, (member, score) in functions.items()}


def as_row(row: ShapeRow) -> dict[str, Any]:
    """Return a row, JSON-ready."""
    values = {name: plain(value) for name, value in asdict(row).items()}
    return values | {"functions": functions_dict(row.functions)}


def plain(value: Any) -> Any:
    """Return a value, JSON-ready: numbers are rounded, and None if they are not finite."""
    if isinstance(value, float):
        return round(value, 4) if np.isfinite(value) else None
    return list(value) if isinstance(value, tuple) else value


def compare_shapes(
    anything: Anything,
    collision: str | Path | None = None,
    *,
    shapes: bool = True,
    coacd: float | Sequence[float] = (),
    keep: float | None = None,
    units: str = "m",
    up: str = BY_FILE,
    report: Report = no_report,
) -> Shapes:
    """Compare collision shapes: how well they preserve the function of an object, and their cost.

    Parameters
    ----------
    anything : path, Open3D or trimesh mesh
        The visual geometry. A URDF contains its collision geometry as well.
    collision : path, optional
        A URDF, SDF, MJCF, USD or mesh, in the same frame, loaded as PyBullet does it (MJCF: as MuJoCo).
    shapes : bool
        Whether candidates are made and compared too: mesh, voxels, compound, V-HACD, hull.
    coacd : float or floats
        Thresholds of CoACD, which takes minutes.
    keep : float
        The share of capacity, level and places that has to be kept, 0 to 1; None: 0.9, and for the best shape 0.95
        with places within 2 mm.

    Raises
    ------
    InputError
        If something cannot be used, the object is not a mesh, or the collision geometry is of another size or missing.
    """
    if keep is not None:
        require_amount("keep", keep, above=0.0, most=1.0)
    if not isinstance(collision, str | Path | None):
        raise InputError(f"collision: expected the path of a file, got {type(collision).__name__}")
    cloud = as_cloud(anything, units=units, up=up, report=report)
    kept = KeepCriteria() if keep is None else KeepCriteria(share=keep)
    subject, frame = Subject(cloud), frame_of(anything, cloud, up, units)
    subject.mesh  # noqa: B018 - clouds without a mesh are refused before anything is measured
    given = collision
    if collision is None and isinstance(anything, str | Path) and Path(anything).suffix.lower() in SAYS_COLLISION:
        collision = anything
    if up == BY_FILE and collision is not None and not isinstance(anything, Cloud):
        report_other_axis(cloud.name, anything, Path(collision), report)
    makes = candidates(cloud, subject.radius, coacd) if shapes else {}
    if shapes and not has_vhacd():
        report(f"{MISSING.format('vhacd', 'shapes')}; it is not compared")
    links = [] if collision is None else list(load_solids(Path(collision), frame))
    if collision is not None and not links:
        none = f"{one_line(Path(collision).name)}: expected collision geometry, found none"
        if given is not None or not shapes:
            raise InputError(none)
        report(f"{none}; only candidates are compared")
    pairs = [*rows_of_links(subject, links, kept, report), *candidate_rows(subject, makes, kept, report)]
    solids, rows = zip(*pairs, strict=True) if pairs else ((), ())
    return Shapes(subject=subject, rows=rows, solids=solids, frame=frame, kept=kept, keep=keep)


def report_other_axis(name: str, anything: Anything, collision: Path, report: Report):
    """Report that an object and its collision geometry have other axes by the standards of their formats."""
    own, other = promised_up(Path(anything if isinstance(anything, str | Path) else name)), promised_up(collision)
    if own != other:
        report(f"{one_line(collision.name)}: taken as {other} up, and {name} as {own} up; if they share axes, set up=")


def rows_of_links(
    subject: Subject, links: list[Solid], criteria: KeepCriteria, report: Report
) -> Iterator[tuple[Solid, ShapeRow]]:
    """Yield a single link with its row; or several links together, and then each that is as large as the object."""
    if len(links) < 2:
        yield from ((link, row_of(subject, link, criteria)) for link in links)
        return
    whole = merged_links(links)
    yield whole, row_of(subject, whole, criteria)
    small = [link.name for link in links if relative_size(subject, link) < 1 / LARGER]
    if small:
        report(f"{subject.cloud.name}: links much smaller than the object have no row: {one_line(', '.join(small))}")
    for link in links:
        try:
            if link.name not in small:
                yield link, row_of(subject, link, criteria)
        except InputError as error:
            report(f"link {one_line(link.name)}: {error}")


def candidate_rows(
    subject: Subject, makes: dict[str, Make], criteria: KeepCriteria, report: Report
) -> Iterator[tuple[Solid, ShapeRow]]:
    """Yield each candidate with its row; candidates that cannot be used are reported and skipped."""
    subject.seen  # noqa: B018 - an object that cannot be used itself is an error before any candidate is made
    for name, make in makes.items():
        try:
            solid = make_solid(name, make)
            yield solid, row_of(subject, solid, criteria)
        except InputError as error:
            report(f"{error}; it is not compared")


def merged_links(links: list[Solid]) -> Solid:
    """Return several links as one solid, a surface if one of them is a surface."""
    if all(link.pieces is not None for link in links):
        return of_pieces("all links", [piece for link in links for piece in link.pieces or ()])
    return surface("all links", *joined_meshes([(link.vertices, link.faces) for link in links]))


def frame_of(anything: Anything, cloud: Cloud, up: str, units: str) -> FileFrame:
    """Return the conversion from the object's own coordinates to those of its cloud."""
    if isinstance(anything, Cloud) or cloud.mesh is None:
        return FileFrame(up="z", units="m", shift=np.zeros(3))
    path = Path(anything) if isinstance(anything, str | Path) else Path("object")
    if "auto" in (up, units):
        raise InputError(f"{one_line(path.name)}: expected its axis and unit to be said, since collision shares them")
    geometry = geometry_of(anything, path.name)
    used = np.unique(geometry.faces)
    converted = to_metres(to_z_up(Geometry(geometry.vertices[used]), up, path, no_report), units, path.name, no_report)
    return FileFrame(up=up, units=units, shift=cloud.mesh.vertices.min(axis=0) - converted.min(axis=0))
