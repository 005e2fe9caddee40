"""The built-in catalogue: 200 procedural household objects in the paper's proportions (§IV-A).

40 sittable, 40 tables, 30 drinking vessels and 90 others, with the paper's hard cases: bar stools as high as
tables, with and without backs; filing cabinets, counters, vases and shoes.
"""

from __future__ import annotations

from .belongings import BELONGINGS
from .boxes import BOXES
from .cabinets import CABINETS
from .catalogue import CatalogueObject, Family, draw
from .chairs import CHAIRS
from .containers import CONTAINERS
from .cups import CUPS
from .desks import DESKS
from .devices import DEVICES
from .dishes import DISHES
from .fixtures import FIXTURES
from .hand_tools import TOOLS
from .lamps import LAMPS
from .low_tables import LOW_TABLES
from .plants import PLANTS
from .sofas import SOFAS
from .stools import STOOLS
from .tables import TABLES

FAMILIES: dict[str, list[Family]] = {
    "sittable": [*CHAIRS, *STOOLS, *SOFAS],
    "table": [*TABLES, *LOW_TABLES, *DESKS],
    "cup": CUPS,
    "none": [
        *CONTAINERS,
        *BOXES,
        *DISHES,
        *CABINETS,
        *DEVICES,
        *LAMPS,
        *PLANTS,
        *FIXTURES,
        *TOOLS,
        *BELONGINGS,
    ],
}


def household_objects(seed: int = 0) -> list[CatalogueObject]:
    """Return the 200 objects of the catalogue; the same seed gives the same meshes, bit for bit."""
    return [item for label, families in FAMILIES.items() for item in draw(families, label, seed)]
