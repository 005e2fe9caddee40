"""Built-in catalogues, made once in a process for all tests that look at them; who changes a mesh changes a copy."""

from __future__ import annotations

from functools import cache

from spherefunc_bullet.scenes.household.household import household_objects
from spherefunc_bullet.scenes.household.parts.legs import CatalogueObject


@cache
def household() -> tuple[CatalogueObject, ...]:
    """Return the objects of `household`."""
    return tuple(household_objects())


def labelled(objects: tuple[CatalogueObject, ...], label: str) -> list[CatalogueObject]:
    """Return the objects of one label."""
    return [item for item in objects if item.label == label]
