"""The built-in catalogue: 200 procedural household objects in the paper's proportions (§IV-A).

40 sittable, 40 tables, 30 drinking vessels and 90 others, with the paper's hard cases: bar stools as high as
tables, with and without backs; filing cabinets, counters, a kitchen island, vases and shoes.
"""

from __future__ import annotations

from .furniture.cabinets import CABINETS
from .furniture.chairs import CHAIRS
from .furniture.desks import DESKS, LOW_TABLES, STOOLS
from .furniture.sofas import SOFAS
from .furniture.tables import TABLES
from .parts.legs import CatalogueObject, Family, draw_objects
from .wares.belongings import BELONGINGS
from .wares.containers import BOWLS, BOXES, CONTAINERS, DISHES
from .wares.cups import CUPS
from .wares.devices import DEVICES
from .wares.fixtures import FIXTURES
from .wares.lamps import LAMPS, PLANTS, TOOLS

FAMILIES: dict[str, list[Family]] = {
    "sittable": [*CHAIRS, *STOOLS, *SOFAS],
    "table": [*TABLES, *LOW_TABLES, *DESKS],
    "cup": [*CUPS, *BOWLS],
    "none": [*CONTAINERS, *BOXES, *DISHES, *CABINETS, *DEVICES, *LAMPS, *PLANTS, *FIXTURES, *TOOLS, *BELONGINGS],
}


def household_objects(seed: int = 0) -> list[CatalogueObject]:
    """Return the 200 objects of the catalogue; the same seed gives the same meshes, bit for bit."""
    return [item for label, families in FAMILIES.items() for item in draw_objects(families, label, seed)]
