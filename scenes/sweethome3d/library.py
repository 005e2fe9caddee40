"""Libraries of furniture for Sweet Home 3D (``.sh3f``) as data sets.

Such a file is a zip archive: a catalogue (``PluginFurnitureCatalog.properties``) and a model for each of its
objects. The archive is not trusted: nothing is unpacked to disk, paths that lead out of it are refused, and the
amount that is read is limited.
"""

from __future__ import annotations

import io
import os
import re
import zipfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np
import trimesh

from spherefunc_bullet.datasets.catalogue import write_manifest
from spherefunc_bullet.errors import InputError, explaining
from spherefunc_bullet.formats.files import prepare_folder, require_ordinary, write_bytes

from ..household.parts.solids import stand
from .purposes import Purpose, purpose_of, slug

CATALOGUE = "PluginFurnitureCatalog.properties"
MEMBER_LIMIT = 200 * 2**20  # bytes of one member, unpacked
LIBRARY_LIMIT = 4 * 2**30  # bytes of all members read, unpacked
COLUMNS = ("file", "label", "also", "category", "group", "catalogue_category", "creator", "license", "ambiguous")
FORMATS = (".obj", ".stl", ".ply", ".off", ".glb")
# Sweet Home 3D looks along its z axis with y up; here z is up and fronts face -y.
Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])

_ENTRY = re.compile(r"(\w+)#(\d+)")
_LINE = re.compile(r"((?:\\.|[^\\=:\s])+)\s*[=:\s]\s*(.*)", re.DOTALL)
_ESCAPE = re.compile(r"\\(?:u([0-9a-fA-F]{4})|(.))", re.DOTALL)


@dataclass(frozen=True, kw_only=True)
class FurnitureEntry:
    """One object of a library, as its catalogue describes it."""

    number: int
    name: str
    category: str
    model: str  # path inside the archive
    size: tuple[float, float, float]  # width, depth, height, metres
    rotation: np.ndarray  # (3, 3), in the model's frame, y up
    door_or_window: bool
    creator: str
    license: str


@dataclass(frozen=True, kw_only=True)
class ImportSummary:
    """The result of an import."""

    manifest: Path
    labels: dict[str, int]  # objects in the manifest, by label
    ambiguous: int  # objects whose function people would dispute: left out unless they are included explicitly
    skipped: int  # objects that could not be read

    @property
    def imported(self) -> int:
        return sum(self.labels.values())


def import_library(
    path: str | os.PathLike,
    directory: str | os.PathLike,
    *,
    include_ambiguous: bool = False,
    report: Callable[[str], None] | None = None,
    progress: Callable[[list], Iterable] = iter,
) -> ImportSummary:
    """Write the objects of a library as PLY, in metres, z up, on the ground, with a ``manifest.csv``.

    Parameters
    ----------
    path : path
        The ``.sh3f`` file.
    directory : path
        Created if it is missing.
    include_ambiguous : bool
        Also write the objects whose function people would dispute (bowls, beds, desks with a hutch).
    report : callable, optional
        Called with one line for each object that cannot be used; the others are still imported.
    progress : callable
        Yields the objects of a list, and may show the progress.

    Raises
    ------
    InputError
        If the file is no such library, or the directory cannot be written.
    """
    path, directory = Path(path), Path(directory)
    report = report or (lambda line: None)
    with _Library(path) as library:
        entries = list(library.entries(report))
        rows, skipped, disputed = [], library.broken, 0
        prepare_folder(directory)
        for entry in progress(entries):
            named = purpose_of(entry.name, entry.category, entry.size[2])
            purpose = Purpose("none") if entry.door_or_window else named
            disputed += purpose.ambiguous
            if include_ambiguous or not purpose.ambiguous:
                row = _import_object(library, entry, purpose, directory, report)
                rows += [row] if row else []
                skipped += row is None
        manifest = write_manifest(directory, COLUMNS, rows)
    labels = dict(Counter(row[1] for row in rows))
    return ImportSummary(manifest=manifest, labels=labels, ambiguous=disputed, skipped=skipped)


def _import_object(
    library: _Library, entry: FurnitureEntry, purpose: Purpose, directory: Path, report: Callable[[str], None]
) -> tuple[str | int, ...] | None:
    """Write one object and return its row of the manifest; report and return None if it cannot be read."""
    try:
        mesh = place_model(library.model(entry), entry)
    except InputError as error:
        report(str(error))
        return None
    category, group = slug(entry.name), f"sh3f_{slug(library.path.stem)}"
    file = f"{slug(library.path.stem)}_{entry.number:03d}_{category}.ply"
    write_bytes(directory / file, mesh.export(file_type="ply", encoding="binary"))
    about = (entry.category, entry.creator, entry.license, int(purpose.ambiguous))
    return file, purpose.label, purpose.also, category, group, *about


def place_model(mesh: trimesh.Trimesh, entry: FurnitureEntry) -> trimesh.Trimesh:
    """Return a model rotated and scaled to its catalogue size, z up, standing on z = 0 (m).

    Sweet Home 3D stretches the rotated model so that its bounding box is width x height x depth exactly.
    """
    vertices = mesh.vertices @ entry.rotation.T
    extent = np.ptp(vertices, axis=0)
    width, depth, height = entry.size
    scale = np.divide([width, height, depth], extent, out=np.ones(3), where=extent > 1e-9)
    vertices = (vertices * scale) @ Z_UP_FROM_Y_UP.T
    return stand(trimesh.Trimesh(vertices, mesh.faces, process=False))


class _Library:
    """An open archive that reads only what is safe to read."""

    def __init__(self, path: Path):
        self.path = path
        self.broken = 0  # entries of the catalogue without a usable name, model or size
        self._left = LIBRARY_LIMIT
        require_ordinary(path)
        wanted = f"{path}: expected a Sweet Home 3D library (.sh3f, a zip archive)"
        with explaining(wanted, OSError, zipfile.BadZipFile, why="; "):
            self._archive = zipfile.ZipFile(path)

    def __enter__(self) -> _Library:
        return self

    def __exit__(self, *exception) -> None:
        self._archive.close()

    def entries(self, report: Callable[[str], None]) -> Iterator[FurnitureEntry]:
        """Yield the catalogue's objects in order; report those without a full description."""
        with explaining(f"{self.path}: expected a Sweet Home 3D library with {CATALOGUE}", InputError, why="; "):
            properties = parse_properties(self.read(CATALOGUE).decode("latin-1"))
        objects: dict[int, dict[str, str]] = {}
        for key, value in properties.items():
            if match := _ENTRY.fullmatch(key):
                objects.setdefault(int(match[2]), {})[match[1]] = value
        for number, fields in sorted(objects.items()):
            try:
                yield _entry(number, fields, properties.get("license", ""))
            except (KeyError, ValueError) as error:
                self.broken += 1
                report(f"{self.path.name}, object {number}: expected a name, a model and a size; got {error!r}")

    def read(self, name: str) -> bytes:
        """Return one member, checked: inside the archive, present, whole and not too large."""
        where = f"{self.path.name}: {name}"
        parts = PurePosixPath(name.replace("\\", "/")).parts
        if ".." in parts or ":" in name:
            raise InputError(f"{where}: expected a path inside the archive")
        try:
            member = self._archive.getinfo(name.lstrip("/"))
            limit = min(MEMBER_LIMIT, self._left)
            # The declared size can lie, so what comes out is counted too.
            with self._archive.open(member) as stream:
                data = stream.read(limit + 1) if member.file_size <= limit else None
        except KeyError:
            raise InputError(f"{where}: expected in the archive, is missing") from None
        except Exception as error:  # zipfile and its codecs raise many kinds for damaged members
            raise InputError(f"{where}: expected a readable member, got {type(error).__name__}: {error}") from error
        if data is None or len(data) > limit:
            raise InputError(f"{where}: expected at most {limit / 2**20:.0f} MB unpacked, got more")
        self._left -= len(data)
        return data

    def model(self, entry: FurnitureEntry) -> trimesh.Trimesh:
        """Return an object's model in its own frame and unit, without materials."""
        where = f"{self.path.name}: {entry.name} ({entry.model})"
        suffix = PurePosixPath(entry.model).suffix.lower()
        if suffix not in FORMATS:
            raise InputError(f"{where}: expected a model in {', '.join(FORMATS)}, got {suffix or 'no suffix'}")
        return parse_model(self.read(entry.model), suffix[1:], where)


def parse_model(data: bytes, kind: str, where: str) -> trimesh.Trimesh:
    """Return the surface in a model file's bytes, its equal vertices merged.

    Raises
    ------
    InputError
        If it holds no triangles, or coordinates that are not finite.
    """
    try:
        mesh = trimesh.load(io.BytesIO(data), file_type=kind, force="mesh", process=False, skip_materials=True)
        mesh = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    except Exception as error:  # damaged files make the readers raise exceptions of any kind
        raise InputError(f"{where}: expected a model, got {type(error).__name__}: {error}") from error
    if not len(mesh.faces) or not np.isfinite(mesh.vertices).all():
        raise InputError(f"{where}: expected triangles with finite coordinates, got {len(mesh.faces)} faces")
    mesh.merge_vertices()
    mesh.remove_unreferenced_vertices()
    return mesh


def _entry(number: int, fields: dict[str, str], license_name: str) -> FurnitureEntry:
    """Return a catalogue entry; KeyError or ValueError names what it lacks."""
    size = tuple(float(fields[key]) / 100 for key in ("width", "depth", "height"))
    rotation = np.array(fields.get("modelRotation", "1 0 0 0 1 0 0 0 1").split(), dtype=float)
    if not all(0 < length < 1000 for length in size):
        raise ValueError(f"size {size} m")
    if len(rotation) != 9 or not np.isfinite(rotation).all():
        raise ValueError(f"modelRotation {fields['modelRotation']}")
    return FurnitureEntry(
        number=number,
        name=fields["name"].strip(),
        category=fields.get("category", "").strip(),
        model=fields["model"].strip(),
        size=size,
        rotation=rotation.reshape(3, 3),
        door_or_window=fields.get("doorOrWindow", "").strip().lower() == "true",
        creator=fields.get("creator", "").strip(),
        license=(fields.get("license") or license_name).strip(),
    )


def parse_properties(text: str) -> dict[str, str]:
    """Return the keys and values of a Java properties file.

    Examples
    --------
    >>> parse_properties("# furniture\\nname#1=Caf\\\\u00e9 table\\nwidth#1 : 62.5")
    {'name#1': 'Café table', 'width#1': '62.5'}
    """
    logical = re.sub(r"(?<!\\)((?:\\\\)*)\\\r?\n[ \t]*", r"\1", text)
    lines = (line.lstrip() for line in logical.splitlines())
    matches = (_LINE.fullmatch(line) for line in lines if line and line[0] not in "#!")
    return {_unescape(match[1]): _unescape(match[2].rstrip()) for match in matches if match}


def _unescape(text: str) -> str:
    special = {"n": "\n", "t": "\t", "r": "\r", "f": "\f"}
    return _ESCAPE.sub(lambda m: chr(int(m[1], 16)) if m[1] else special.get(m[2], m[2]), text)
