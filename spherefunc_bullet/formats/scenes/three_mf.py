"""3MF, read by trimesh: all parts in one frame, converted from the file's own unit to metres."""

from __future__ import annotations

import io
import zipfile

from .. import FormatError
from ..files import require_members
from ..sources import Geometry, Source
from .parts import joined, parts_of, plain_xml, require_few_instances, scene_of

_METRES = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}


def read_3mf(source: Source) -> Geometry:
    """Return the vertices (N, 3) in metres and triangles (M, 3) of all parts."""
    import lxml  # noqa: F401 - trimesh imports it only when it reads such a file

    unit = _checked_unit(source.data)
    geometry = joined(parts_of(scene_of(source.data, "3mf"), "faces"))
    return Geometry(unit * geometry.vertices, geometry.faces)


def _checked_unit(data: bytes) -> float:
    """Return the file's unit in metres, after checking every model in the archive before trimesh unpacks it."""
    children: dict[str, list[str]] = {}
    roots, units = [], []
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        require_members(archive)
        for name in archive.namelist():
            if not name.lower().endswith(".model"):
                continue
            tree = plain_xml(archive.read(name))
            units += [tree.get("unit", "millimeter")] if "3d/3dmodel.model" in name.lower() else []
            for item in tree.findall(".//{*}object"):
                shown = [component.get("objectid", "") for component in item.findall(".//{*}component")]
                children.setdefault(item.get("id", ""), []).extend(shown)
            roots += [item.get("objectid", "") for item in tree.findall(".//{*}build/{*}item")]
    require_few_instances(children, roots)
    if not units or units[0] not in _METRES:
        raise FormatError(f"expected a model in one of {', '.join(_METRES)}, got {units[:1] or 'none'}; is it damaged?")
    return _METRES[units[0]]
