"""What a measurement depends on: its code without words, and other files byte for byte.

A measurement names the modules that it measures. What these import counts too, so that no dependence is forgotten;
what they import and cannot change a figure is left out by name.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

PACKAGE = "spherefunc_bullet"
FOLDERS = ("compare", "scenes", "fast_sim")  # of the repository, installed inside the package
LENGTH = 12  # digits kept of a hash

# How work is shared out, what options are called, what is said meanwhile, and formats that no object measured has.
NEVER_DECIDES = (
    f"{PACKAGE}/batch/",
    f"{PACKAGE}/commands/",
    f"{PACKAGE}/console.py",
    f"{PACKAGE}/errors.py",
    f"{PACKAGE}/formats/files.py",
    f"{PACKAGE}/formats/points/",
    f"{PACKAGE}/formats/scenes/",
    f"{PACKAGE}/processes/",
)

Fingerprint = dict[str, str]  # file, from the repository's root -> hash


def fingerprint(root: Path, modules: Iterable[str], without: Iterable[str] = (), files: Iterable[str] = ()):
    """Return the hash of every module that some modules import, themselves included, and of other files.

    Parameters
    ----------
    root : path
        The repository.
    modules, files : iterable of str
        Paths from the root.
    without : iterable of str
        How the paths of modules begin that are left out, with what only they import.
    """
    code = {module: code_hash(root / module) for module in imported_modules(root, modules, without)}
    return code | {file: digest((root / file).read_bytes()) for file in sorted(files)}


def imported_modules(root: Path, modules: Iterable[str], without: Iterable[str] = ()) -> list[str]:
    """Return the modules and all that they import, at whatever place, of the repository; sorted paths."""
    found, waiting, left_out = set(), list(modules), (*NEVER_DECIDES, *without)
    while waiting:
        module = waiting.pop()
        if module not in found and not module.startswith(left_out):
            found.add(module)
            waiting += [path for name in imported_names(root, module) if (path := path_of(root, name))]
    return sorted(found)


@cache
def imported_names(root: Path, module: str) -> frozenset[str]:
    """Return all that a module may import, by dotted names of modules and of what is in them."""
    names, own = set(), module_name(module).split(".")
    for node in executed_nodes(ast.parse((root / module).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = own[: len(own) - node.level] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            names |= {base, *(f"{base}.{alias.name}" for alias in node.names)}
    return frozenset(names)


def executed_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield a tree's nodes without what only type checkers read."""
    if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        return
    yield node
    for child in ast.iter_child_nodes(node):
        yield from executed_nodes(child)


def module_name(path: str) -> str:
    """Return the dotted name of a module as it is installed; a package's own file keeps its ``__init__``."""
    parts = Path(path).with_suffix("").parts
    return ".".join(parts if parts[0] == PACKAGE else (PACKAGE, *parts))


@cache
def path_of(root: Path, name: str) -> str | None:
    """Return the path of a module of the repository from its root, None for any other name."""
    first, *parts = name.split(".")
    if first != PACKAGE or not parts:
        return None  # the package's own file only says where its names are
    place = Path(*parts) if parts[0] in FOLDERS else Path(PACKAGE, *parts)
    for path in (place.with_suffix(".py"), place / "__init__.py"):
        if (root / path).is_file():
            return path.as_posix()
    return None


@cache
def code_hash(path: Path) -> str:
    """Return the hash of a module's syntax tree: layout, comments and docstrings do not count."""
    return digest(repr(shape(ast.parse(path.read_text(encoding="utf-8")))).encode())


def shape(node: object) -> object:
    """Return a syntax tree without docstrings as tuples, the same by every version of Python."""
    if isinstance(node, list):
        return [shape(item) for item in node]
    if not isinstance(node, ast.AST):
        return node
    fields = {name: value for name, value in ast.iter_fields(node) if value not in (None, [])}
    if "body" in fields and isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        fields["body"] = [part for part in fields["body"] if not is_text(part)]
    return (type(node).__name__, [(name, shape(value)) for name, value in fields.items()])


def is_text(node: ast.AST) -> bool:
    """Return whether a statement is a string and nothing else, as docstrings are."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def digest(content: bytes) -> str:
    """Return the first digits of a hash."""
    return hashlib.sha256(content).hexdigest()[:LENGTH]
