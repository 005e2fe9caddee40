"""MJCF, compiled by MuJoCo: the geoms that it shows, or those that collide, with every joint at its reference.

MuJoCo gets one tree, with what the file includes, and the bytes of its meshes, so that it opens no files itself. What
moves or is painted is left out before, as are planes and height fields: they are the ground, not the object.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ...errors import explaining
from .. import FormatError
from ..files import refusing
from ..sources import Geometry, Source
from .named_meshes import find_mesh, mesh_source
from .parts import MAX_INSTANCES, SEEN, Part, joined, plain_xml, primitive

_SECTIONS = ("compiler", "default", "asset", "worldbody")
_GEOMETRY = ("angle", "coordinate", "eulerseq", "fitaabb")  # of the compiler; its other settings move no geom
_KEPT = ("body", "geom", "frame", "replicate")  # in a body; others are refused, but for these:
_LEFT_OUT = ("joint", "freejoint", "inertial", "site", "camera", "light", "plugin")
_OPAQUE = ("name", "class", "rgba")  # of a material; textures change no shape
_BESIDE = "beside"  # mark of a mesh until it is found
_GROUPS = 3  # MuJoCo's viewer shows geoms of the first three groups
_COMPILING = threading.Lock()
Find = Callable[..., tuple[str, Source]]  # returns the first of several names under which a file is found, and the file


def read_mjcf(source: Source) -> Geometry:
    """Return the vertices (N, 3), metres, and triangles (M, 3) of all geoms that are seen."""
    return joined([part for _, part in bodies(source, collision=False)], "visible geoms beside planes", SEEN[1])


def named_sources(source: Source) -> dict[str, Source]:
    """Return the files that it includes and its meshes, by their names."""
    named, folder = {}, source.path.parent

    def find(*names: str) -> tuple[str, Source]:
        """Return the first of the names under which there is a file, and the file, which is remembered."""
        name = next((name for name in names if find_mesh(name, folder)), names[0])
        if name not in named:
            named[name] = Source(mesh_source(name, folder).path, "")  # what is included is not compiled by itself
        return name, named[name]

    _model(source, find)
    return named


def bodies(source: Source, collision: bool) -> Iterator[tuple[str, Part]]:
    """Yield the name of its body and the placed triangles of each geom that is seen, or that collides."""
    import mujoco

    named = source.named
    tree, meshes = _model(source, lambda *names: next((name, named[name]) for name in names if name in named))
    files = {name: mesh.data for name, mesh in meshes.items()}
    with _COMPILING, _without_warnings(), explaining("expected an MJCF that MuJoCo compiles", ValueError, why="; "):
        model = mujoco.MjModel.from_xml_string(ElementTree.tostring(tree, encoding="unicode"), files)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for geom in np.flatnonzero(_colliding(model) if collision else _seen(model)):
        if (part := _geom_part(model, geom)) is not None:
            body, place = model.geom_bodyid[geom], part[0] @ data.geom_xmat[geom].reshape(3, 3).T
            yield model.body(body).name or f"body {body}", (place + data.geom_xpos[geom], part[1])


@contextmanager
def _without_warnings() -> Iterator[None]:
    """Keep MuJoCo's warnings, of the whole process, from stdout and from a file that it makes in the current folder."""
    import mujoco

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda line: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _colliding(model: Any) -> np.ndarray:
    return (model.geom_contype > 0) | (model.geom_conaffinity > 0)


def _seen(model: Any) -> np.ndarray:
    """Return which geoms are seen (G,): of a body with geoms that are only shown, those of the groups of these.

    If they are less than half as large as what collides, they are marks on it, and all is seen.
    """
    hidden = (model.geom_rgba[:, 3] == 0) | (model.geom_group >= _GROUPS)
    if model.nmat:
        hidden |= (model.geom_matid >= 0) & (model.mat_rgba[model.geom_matid, 3] == 0)
    seen, only_shown = ~hidden, ~hidden & ~_colliding(model)
    for body in np.unique(model.geom_bodyid[only_shown]):
        of_body = seen & (model.geom_bodyid == body)
        stand_ins = of_body & ~np.isin(model.geom_group, model.geom_group[of_body & only_shown])
        if model.geom_rbound[of_body & ~stand_ins].max() >= model.geom_rbound[stand_ins].max(initial=0) / 2:
            seen &= ~stand_ins
    return seen


def _geom_part(model: Any, geom: int) -> Part | None:
    """Return the triangles of a geom in its own frame; None for planes and height fields."""
    import mujoco

    kinds, kind, size = mujoco.mjtGeom, int(model.geom_type[geom]), model.geom_size[geom]
    if kind == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
        vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        return vertices, model.mesh_face[face : face + model.mesh_facenum[mesh]].astype(np.int64)
    if kind == kinds.mjGEOM_BOX:
        return primitive("box", extents=2 * size)
    if kind == kinds.mjGEOM_CYLINDER:
        return primitive("cylinder", radius=size[0], height=2 * size[1])
    if kind == kinds.mjGEOM_CAPSULE:
        return primitive("capsule", radius=size[0], height=2 * size[1])
    if kind == kinds.mjGEOM_SPHERE:
        return primitive("icosphere", radius=size[0])
    if kind == kinds.mjGEOM_ELLIPSOID:
        vertices, faces = primitive("icosphere", radius=1.0)
        return vertices * size, faces
    return None


def _model(source: Source, find: Find) -> tuple[ElementTree.Element, dict[str, Source]]:
    """Return the tree that MuJoCo compiles, and the sources of its meshes by the names that it has for them."""
    root = _one_tree(source, find)
    settings = {name: value for compiler in root.iter("compiler") for name, value in compiler.attrib.items()}
    _leave_geometry(root)
    meshes = {}
    for mesh in (mesh for mesh in root.iter("mesh") if mesh.get("file")):
        path, beside = _path(mesh.attrib["file"]), mesh.attrib.pop(_BESIDE)
        folder = settings.get("meshdir", settings.get("assetdir", ""))
        name = path.name if settings.get("strippath") == "true" else str(PurePosixPath(folder, path))
        mesh.attrib |= {"name": mesh.get("name", path.stem), "file": f"{len(meshes)}{path.suffix}"}
        _, meshes[mesh.attrib["file"]] = find(name, str(PurePosixPath(beside, path)))
    return root, meshes


def _one_tree(source: Source, find: Find) -> ElementTree.Element:
    """Return the root of an MJCF with the sections that are read, also of the files that it includes."""
    root = plain_xml(source.data)
    if root.tag != "mujoco":
        raise FormatError(f"expected an MJCF, whose root is 'mujoco', got {root.tag[:80]!r}; is it part of a model?")
    sections = list(_included(root, PurePosixPath(), find, set()))
    if any(section.find("flex") is not None for section in sections if section.tag == "deformable"):
        raise FormatError("expected bodies of rigid geoms, got 'flex', which is not read")
    root[:] = [section for section in sections if section.tag in _SECTIONS]
    return root


def _leave_geometry(root: ElementTree.Element):
    """Remove from a tree what places no geom and hides none."""
    for compiler in root.iter("compiler"):
        _keep(compiler, _GEOMETRY)
    for material in root.iter("material"):
        _keep(material, _OPAQUE)
    for assets in root.iter("asset"):
        assets[:] = [each for each in assets if each.tag in ("mesh", "material")]
    if sum(_simplify(world, 1) for world in root.iter("worldbody")) > MAX_INSTANCES:
        raise FormatError(f"expected at most {MAX_INSTANCES:,} geoms, got more; join them")
    materials = {material.get("name") for material in root.iter("material")}
    for painted in root.iter():  # parts of robots are painted in the file that includes them
        if painted.get("material") not in materials:
            painted.attrib.pop("material", None)


def _included(
    element: ElementTree.Element, folder: PurePosixPath, find: Find, paths: set[Path]
) -> Iterator[ElementTree.Element]:
    """Yield the children of an element, those of the files that it includes in their places.

    Names are relative to the model's folder, or else to that of the file in which they stand, which meshes are marked
    with.
    """
    for child in element:
        if child.tag != "include":
            child.attrib |= {_BESIDE: str(folder)} if child.tag == "mesh" and "file" in child.attrib else {}
            child[:] = list(_included(child, folder, find, paths))
            yield child
            continue
        given = _path(child.get("file", ""))
        name, source = find(str(given), str(folder / given))
        if source.path in paths:
            raise FormatError(f"expected each file to be included once, got {name[:80]!r} again, as MuJoCo refuses")
        paths.add(source.path)
        with refusing(source.path):
            yield from list(_included(plain_xml(source.data), PurePosixPath(name).parent, find, paths))


def _path(name: str) -> PurePosixPath:
    """Return the path of a file that an MJCF names, which may be written as in Windows."""
    return PurePosixPath(name.replace("\\", "/"))


def _keep(element: ElementTree.Element, names: tuple[str, ...]):
    """Remove an element's children, and all of its attributes but those of these names."""
    element.attrib = {name: element.attrib[name] for name in names if name in element.attrib}
    element[:] = []


def _simplify(element: ElementTree.Element, copies: int) -> int:
    """Remove what is no geometry from a body of which there are ``copies``, and return the number of its geoms."""
    element[:] = [child for child in element if child.tag not in _LEFT_OUT and "hfield" not in child.attrib]
    count = 0
    for child in element:
        if child.tag not in _KEPT:
            raise FormatError(f"expected bodies of rigid geoms, got {child.tag[:80]!r}, which is not read")
        with explaining(f"expected a whole number of copies, got {child.get('count', '')[:80]!r}", ValueError):
            inner = copies * int(child.get("count", 1))
        if inner > MAX_INSTANCES:
            raise FormatError(f"expected at most {MAX_INSTANCES:,} copies of a body, got {inner:,}; join them")
        if child.tag == "geom":
            child[:] = []
        count += copies if child.tag == "geom" else _simplify(child, inner)
    return count
