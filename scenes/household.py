"""The built-in catalogue: 200 procedural household objects in the paper's proportions (§IV-A).

40 sittable, 40 tables, 30 drinking vessels and 90 others, with the paper's hard cases: bar stools as high as
tables, with and without backs; filing cabinets, counters, vases and shoes.
"""

from __future__ import annotations

from .belongings import BELONGINGS
from .cabinets import CABINETS
from .catalogue import CatalogueObject, Family, draw
from .containers import CONTAINERS
from .cups import CUPS
from .devices import DEVICES
from .fixtures import FIXTURES
from .seats import SEATS
from .tables import TABLES

FAMILIES: dict[str, list[Family]] = {
    "sittable": SEATS,
    "table": TABLES,
    "cup": CUPS,
    "none": [*CONTAINERS, *CABINETS, *DEVICES, *FIXTURES, *BELONGINGS],
}


def household_objects(seed: int = 0) -> list[CatalogueObject]:
    """Return the 200 objects of the catalogue; the same seed gives the same meshes, bit for bit."""
    return [item for label, families in FAMILIES.items() for item in draw(families, label, seed)]
