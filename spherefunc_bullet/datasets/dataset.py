"""Data sets: files of objects, and the functions of each.

``DATA`` on the command line is a folder with a ``manifest.csv``, a folder of folders named for their label,
or the name of a built-in catalogue.
"""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from ..errors import InputError, escaped, explaining, one_line
from .catalogue import built_catalogue, catalogue_entry_points

NONE = "none"
SUFFIXES = {".ply", ".pcd", ".obj", ".stl", ".3ds", ".off", ".glb", ".gltf", ".dae", ".3mf", ".xyz"}
SUFFIXES |= {".las", ".laz", ".npz", ".npy"}  # CSV and TXT are more often tables, and URDF names files beside it


@dataclass(frozen=True, kw_only=True)
class DatasetObject:
    """One object of a data set."""

    path: Path
    functions: frozenset[str]  # the labels, its primary functions; empty for none
    also: frozenset[str] = frozenset()  # functions that are true as well or disputed, but not primary
    category: str = ""
    group: str = ""  # its source
    source: str = ""  # its author, if that must be named
    license: str = ""
    of: str = ""  # file name of the object of which it is an impaired or harmless copy


@dataclass(frozen=True)
class Dataset:
    """Labelled objects, in the order of the manifest."""

    name: str
    objects: tuple[DatasetObject, ...] = field(repr=False)
    folder: Path | None = None  # that contains the files of the objects

    def __post_init__(self):
        spellings: dict[str, str] = {}
        for name in self.functions:
            if (other := spellings.setdefault(name.casefold(), name)) != name:
                raise InputError(f"{self.name}: expected one spelling of a label, got {other!r} and {name!r}")

    @cached_property
    def functions(self) -> tuple[str, ...]:
        """The names of all functions that some object has, sorted."""
        return tuple(sorted(set().union(*(item.functions for item in self.objects))))

    def __len__(self) -> int:
        return len(self.objects)

    def name_of(self, path: Path) -> str:
        """Return the name of an object, which does not depend on the place of the data set: its path in the folder."""
        return escaped(str(path) if self.folder is None else Path(os.path.relpath(path, self.folder)).as_posix())


def open_dataset(data: str | Path) -> Dataset:
    """Open a data set by folder or by the name of a catalogue.

    Raises
    ------
    InputError
        If there is neither such a folder nor such a catalogue, or the manifest is not usable.
    """
    if not isinstance(data, str | Path) or data == "":  # as a path, "" would be the current folder
        raise InputError(f"data set: expected a folder or the name of a catalogue, got {one_line(repr(data)):.200}")
    path = Path(data)
    if os.path.isdir(path):
        manifest = path / "manifest.csv"
        return read_manifest(manifest) if os.path.isfile(manifest) else read_label_folders(path)
    if str(data) in (catalogues := catalogue_entry_points()):
        return read_manifest(built_catalogue(str(data)))
    if os.path.isfile(path) and path.suffix.lower() == ".csv":
        return read_manifest(path)
    kinds = f"a folder with manifest.csv or label folders, or one of {', '.join(sorted(catalogues))}"
    came = "a file" if os.path.exists(path) else "nothing of that name"
    raise InputError(f"{data}: expected {kinds}; found {came}")


def require_no_label(subject: str, folder: Path, data: Path):
    """Raise InputError for a folder in a data set whose folders are labels: files in it would be objects of one."""
    if data.resolve() in folder.resolve().parents and data.is_dir() and not (data / "manifest.csv").is_file():
        raise InputError(f"{subject}: expected a folder outside {data}, in which folders are labels")


def joined_datasets(datasets: Sequence[Dataset]) -> Dataset:
    """Return one data set with the objects of several, such as whole models and scans of them."""
    if len(datasets) == 1:
        return datasets[0]
    objects = tuple(item for dataset in datasets for item in dataset.objects)
    return Dataset(" and ".join(dataset.name for dataset in datasets), objects)


def distinct_names(objects: Sequence[DatasetObject]) -> tuple[list[str], list[str]]:
    """Return distinct names of the objects, and the name of the original of each copy; empty for objects that are none.

    Catalogues use the same names, so a name that occurred before is preceded by its folder. If several objects have the
    name of the original, it is the last one before the copy, or else the first.
    """
    names: list[str] = []
    first: dict[str, str] = {}  # file name -> distinct name of the first object that is no copy
    for item in objects:
        name = item.path.name
        names.append(f"{item.path.parent.name}/{name}" if name in first else name)
        if not item.of:
            first.setdefault(name, name)
    last, originals = dict[str, str](), []
    for item, name in zip(objects, names, strict=True):
        of = Path(item.of).name
        originals.append(last.get(of, first.get(of, of)))
        if not item.of:
            last[item.path.name] = name
    return names, originals


def read_manifest(manifest: Path) -> Dataset:
    """Read a ``manifest.csv`` with the columns file and label, and further ones if there are any.

    Several functions are separated by ``;``; ``none`` stands for no function.
    """
    rows = csv_table(manifest, "file", "label")
    objects = tuple(_manifest_object(manifest, rows.line_num, row) for row in rows)
    if not objects:
        raise InputError(f"{manifest}: expected at least one row below the header, got none")
    return Dataset(manifest.parent.resolve().name, objects, manifest.parent)


def csv_table(path: Path, *columns: str) -> csv.DictReader[str]:
    """Return the rows of a CSV file with at least the given columns.

    Raises
    ------
    InputError
        If it cannot be read, lacks a column, or has a quote that is not closed, which would take in all lines below.
    """
    expected = f"{path}: expected a CSV file in UTF-8 with every quote closed"
    with explaining(expected, OSError, UnicodeDecodeError, csv.Error, why="; "):
        lines = path.read_text(encoding="utf-8-sig").splitlines()
        list(csv.reader(lines, strict=True))
    rows = csv.DictReader(lines)
    rows.fieldnames = got = [name.strip() for name in rows.fieldnames or ["no columns"]]
    if any(got.count(name) != 1 for name in columns):
        expected = " and ".join(filter(None, [", ".join(columns[:-1]), columns[-1]]))
        raise InputError(f"{path}: expected the columns {expected}, separated by commas, got {', '.join(got)}")
    return rows


def _manifest_object(manifest: Path, line: int, row: dict[str, str | None]) -> DatasetObject:
    file, label = (row["file"] or "").strip(), (row["label"] or "").strip()
    where = f"{manifest}, line {line}"
    if not file or not label:
        raise InputError(f"{where}: expected a file and a label, such as cup or none, got {file!r} and {label!r}")
    if any(more := row.get(None, [])):
        raise InputError(f"{where}: expected a value for each column, got {more[0]!r} too; separate functions by ;")
    path = manifest.parent / file
    if not lies_below(manifest.parent, path):
        raise InputError(f"{where}: expected a file below the manifest's folder, got {file}")
    with explaining(where, InputError, why=": "):
        functions, also = parse_functions(label), parse_functions(row.get("also") or "")
    return DatasetObject(
        path=path,
        functions=functions,
        also=also,
        **{name: (row.get(name) or "").strip() for name in ("category", "group", "source", "license", "of")},
    )


def lies_below(folder: Path, path: Path) -> bool:
    """Return whether a path leads to a place below a folder, after following all links."""
    try:
        return Path(os.path.realpath(folder)) in Path(os.path.realpath(path)).parents
    except ValueError:  # a null byte in a name
        return False


def parse_functions(text: str) -> frozenset[str]:
    """Return the functions of a label.

    Examples
    --------
    >>> sorted(parse_functions("table; sittable")), parse_functions("none")
    (['sittable', 'table'], frozenset())
    >>> parse_functions("None")
    frozenset()

    Raises
    ------
    InputError
        If it holds a comma, which would make one function of two, or is a list or set of Python.
    """
    if re.search(r"[,\[{]", text):
        raise InputError(f"label {text!r}: expected functions separated by ;, without commas and brackets")
    names = (name.strip() for name in text.split(";"))
    return frozenset(name for name in names if name.lower() not in ("", NONE))


def label_text(functions: Iterable[str], separator: str = ";") -> str:
    """Return functions as a manifest writes them.

    Examples
    --------
    >>> label_text({"table", "sittable"}), label_text([])
    ('sittable;table', 'none')
    """
    return separator.join(sorted(functions)) or NONE


def read_label_folders(folder: Path) -> Dataset:
    """Read a folder of folders named for their label (``cup/``, ``none/``, ``table;sittable/``)."""
    objects = []
    for label in folders_in(folder):
        folders_in(label)  # one that cannot be read has no files for rglob
        files = [path for path in names_below(label) if path.suffix.lower() in SUFFIXES]
        functions = parse_functions(label.name) if files else frozenset()
        objects += [DatasetObject(path=path, functions=functions, category=label.name) for path in files]
    if not objects:
        expected = "a manifest.csv, or folders named for their label with models in them"
        raise InputError(f"{folder}: expected {expected}; found neither")
    outside = next((item.path for item in objects if not lies_below(folder, item.path)), None)
    if outside is not None:
        raise InputError(f"{outside}: expected a file below {folder}, got a link that leads out of it; copy the file")
    return Dataset(folder.resolve().name, tuple(objects), folder)


def folders_in(folder: Path) -> list[Path]:
    """Return the folders in a folder that are not hidden, sorted, or raise InputError if it cannot be read."""
    with explaining(f"{folder}: expected a folder that can be read", OSError, why="; "):
        return sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))


def names_below(folder: Path) -> list[Path]:
    """Return what is below a folder, sorted, without hidden files and folders, as macOS and notebooks leave them."""
    below = sorted(folder.rglob("*"))
    return [path for path in below if not any(part.startswith(".") for part in path.relative_to(folder).parts)]


def parse_shard(text: str | None) -> tuple[int, int]:
    """Return which shard and of how many, from 1.

    Examples
    --------
    >>> parse_shard("3/8"), parse_shard(None)
    ((3, 8), (1, 1))
    """
    if text is None:
        return 1, 1
    match = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", text)
    if not match or not 1 <= int(match[1]) <= int(match[2]):
        raise InputError(f"--shard {text}: expected i/n with i from 1 to n, such as 3/8")
    return int(match[1]), int(match[2])


def shard_of(dataset: Dataset, shard: tuple[int, int]) -> Dataset:
    """Return every n-th object of a data set, from the i-th, since neighbours in a manifest have similar costs.

    Raises
    ------
    InputError
        If there are fewer objects than shards, and none for this one.
    """
    index, count = shard
    objects = dataset.objects[index - 1 :: count]
    if not objects:
        raise InputError(f"--shard {index}/{count}: expected at most {len(dataset)} shards, as many as objects")
    return Dataset(dataset.name, objects, dataset.folder)


ALLOWED = ("CC0", "CC-BY", "BSD", "Apache-2.0", "MIT", "Zlib")
FORBIDDEN = ("GPL", "-NC", "-ND", "-SA", "research")


def is_permissive(text: str) -> bool:
    """Return whether a licence, as written in a manifest, permits learning from an object and passing it on.

    Examples
    --------
    >>> is_permissive("CC-BY-3.0"), is_permissive("GPL-2+ (Debian package)"), is_permissive("CC-BY-NC-4.0")
    (True, False, False)
    """
    return any(name in text for name in ALLOWED) and not any(name in text for name in FORBIDDEN)


def sources_of(objects: Sequence[DatasetObject]) -> list[str]:
    """Return the source of each object with a licence, and an empty text for others, which are of a catalogue."""
    return [item.group if item.license else "" for item in objects]


def size_of(path: Path) -> int:
    """Return a file's size in bytes, -1 where there is none."""
    return path.stat().st_size if path.is_file() else -1
