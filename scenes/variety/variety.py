"""A second built-in catalogue: furniture and vessels of other kinds and makes than those of ``household``.

Tables with rims, slats, bumps and glass; seats without legs, with domes, slings and ropes; cups of other outlines; and
what looks like one of these and is none. Most builders draw their make as well as their size, so that each seed has
other combinations of tops and stands. What people would dispute has the other reading in ``also``.
"""

from __future__ import annotations

from ..household.parts.legs import CatalogueObject, Family, draw_objects
from .chairs import CHAIRS
from .cups import CUPS
from .fixtures import FIXTURES
from .seats import SEATS
from .stands import STANDS
from .tables import TABLES
from .vessels import HOLLOW

FAMILIES: dict[str, list[Family]] = {
    "sittable": [*SEATS, *CHAIRS],
    "table": TABLES,
    "cup": CUPS,
    "none": [*HOLLOW, *FIXTURES, *STANDS],
}


def variety_objects(seed: int = 0) -> list[CatalogueObject]:
    """Return the objects of the catalogue; the same seed gives the same meshes, bit for bit."""
    return [item for label, families in FAMILIES.items() for item in draw_objects(families, label, seed)]
