"""Writing of shapes as URDF, SDF or MJCF, with visual and collision geometry, mass and inertia.

Each convex piece is a separate file: PyBullet, Gazebo and MuJoCo all use the hull of such a file, while they treat
groups in a file differently.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ..errors import InputError
from ..formats.files import write_bytes
from ..simulator.statics.body import Body
from .solid import Solid, hull_of

CONCAVE = "concave.obj"  # name of a concave mesh, which PyBullet keeps if the link says so
FORMATS = ("urdf", "sdf", "mjcf")
FIRM = {"solref": "0.004 1", "solmix": "1000"}  # with MuJoCo's default contacts, bodies sink through thin walls


def write_shape(path: Path, visual: Solid, shape: Solid, body: Body, form: str | None = None) -> Path:
    """Write an object with a collision shape, its meshes in a folder next to it, and return its path.

    Parameters
    ----------
    path : Path
        Its ending, .urdf, .sdf or .xml, decides the format unless ``form`` is given.
    visual, shape : Solid
        In the same frame; the shape consists of convex pieces or, for static objects, of a concave surface.
    body : Body
        Provides mass, centre of mass and inertia.
    """
    form = form or {".xml": "mjcf", ".mjcf": "mjcf"}.get(path.suffix.lower(), path.suffix[1:].lower())
    if form not in FORMATS:
        raise InputError(f"{path}: expected a name that ends in .urdf, .sdf or .xml")
    if shape.pieces is None and form == "mjcf":
        raise InputError(f"{path}: expected convex pieces to write, since MuJoCo takes the hull of every mesh")
    folder = f"{path.stem}_meshes"
    seen = f"{folder}/visual.obj"
    write_bytes(path.parent / seen, obj(visual.vertices, visual.faces))
    names = [] if shape.pieces else [f"{folder}/{CONCAVE}"]
    for name in names:
        write_bytes(path.parent / name, obj(shape.vertices, shape.faces))
    for number, piece in enumerate(shape.pieces or ()):
        names.append(f"{folder}/piece_{number:03d}.obj")
        write_bytes(path.parent / names[-1], obj(*hull_of(piece)))
    tree = {"urdf": urdf, "sdf": sdf, "mjcf": mjcf}[form](path.stem, seen, names, body)
    ElementTree.indent(tree)
    return write_bytes(path, ElementTree.tostring(tree, encoding="utf-8", xml_declaration=True) + b"\n")


def obj(vertices: np.ndarray, faces: np.ndarray) -> bytes:
    """Return triangles as OBJ."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


def numbers(*values: float) -> str:
    """Return numbers as text for XML."""
    return " ".join(f"{float(value):.9g}" for value in values)


def moments(body: Body) -> dict[str, str]:
    """Return the inertia about the centre of mass by the names of URDF and SDF."""
    axes = "xyz"
    return {f"i{axes[i]}{axes[j]}": numbers(body.inertia[i, j]) for i in range(3) for j in range(i, 3)}


def urdf(name: str, seen: str, pieces: list[str], body: Body) -> Element:
    """Return a URDF of one link."""
    robot = Element("robot", name=name)
    link = SubElement(robot, "link", name="base", **({"concave": "yes"} if CONCAVE in pieces[0] else {}))
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=numbers(*body.center))
    SubElement(inertial, "mass", value=numbers(body.mass))
    SubElement(inertial, "inertia", moments(body))
    for kind, file in [("visual", seen), *(("collision", piece) for piece in pieces)]:
        SubElement(SubElement(SubElement(link, kind), "geometry"), "mesh", filename=file)
    return robot


def sdf(name: str, seen: str, pieces: list[str], body: Body) -> Element:
    """Return an SDF of one model with one link."""
    root = Element("sdf", version="1.7")
    link = SubElement(SubElement(root, "model", name=name), "link", name="base")
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "pose").text = numbers(*body.center, 0, 0, 0)
    SubElement(inertial, "mass").text = numbers(body.mass)
    inertia = SubElement(inertial, "inertia")
    for moment, value in moments(body).items():
        SubElement(inertia, moment).text = value
    parts = [("visual", "visual", seen), *(("collision", f"piece_{n}", piece) for n, piece in enumerate(pieces))]
    for kind, part, file in parts:
        mesh = SubElement(SubElement(SubElement(link, kind, name=part), "geometry"), "mesh")
        SubElement(mesh, "uri").text = file
    return root


def mjcf(name: str, seen: str, pieces: list[str], body: Body) -> Element:
    """Return an MJCF of one free body."""
    root = Element("mujoco", model=name)
    assets, world = SubElement(root, "asset"), SubElement(root, "worldbody")
    free = SubElement(world, "body", name=name)
    SubElement(free, "freejoint")
    full = [body.inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    SubElement(free, "inertial", pos=numbers(*body.center), mass=numbers(body.mass), fullinertia=numbers(*full))
    SubElement(assets, "mesh", name="visual", file=seen, inertia="shell")
    SubElement(free, "geom", type="mesh", mesh="visual", contype="0", conaffinity="0", group="2")
    for number, file in enumerate(pieces):
        SubElement(assets, "mesh", name=f"piece_{number}", file=file, inertia="shell")  # solid ones may be too thin
        SubElement(free, "geom", type="mesh", mesh=f"piece_{number}", group="3", **FIRM)
    return root
