"""The second catalogue: what it holds, and that each object is a sound model of what it claims to be."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from catalogue_checks import flaws, identical, odd_sizes, pieces_that_touch, unchanged
from catalogues import household, labelled, variety

from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.scenes.household.parts.legs import stretched
from spherefunc_bullet.scenes.variety.variety import variety_objects

# Height and larger horizontal side in metres, of objects in shops: a swing's frame is 2.2 m high, a floor chair's back
# 40 cm, a child's stool 18 cm; a picnic table with its benches is 2.2 m wide.
SIZES = {
    "cup": ((0.045, 0.26), (0.035, 0.2)),
    "table": ((0.24, 1.15), (0.27, 2.4)),
    "sittable": ((0.18, 2.25), (0.24, 2.5)),
    "none": ((0.02, 2.1), (0.035, 2.0)),
}


def level_area(mesh, low: float, high: float, steepest_deg: float) -> np.ndarray:
    """Return the area of faces that face up, no steeper than so, within each centimetre from low to high metres."""
    faces_up = mesh.face_normals[:, 2] > np.cos(np.radians(steepest_deg))
    return np.histogram(
        mesh.triangles_center[faces_up, 2], np.arange(low, high, 0.01), weights=mesh.area_faces[faces_up]
    )[0]


def test_each_function_has_many_families_and_what_was_missing_is_there():
    """Furniture that the models had missed on other sources, and what they had taken for furniture."""
    families = {label: {item.category for item in labelled(variety(), label)} for label in SIZES}
    assert {"rimmed_table", "tray_stand", "slatted_table", "glass_table", "picnic_bench_table"} <= families["table"]
    assert {"floor_chair", "swing", "pouf", "bean_bag", "tub_seat", "toilet", "bar_chair"} <= families["sittable"]
    assert {"aquarium", "espresso_machine", "crib", "pool", "bird_bath", "necked_vessel"} <= families["none"]
    assert min(len(found) for found in families.values()) >= 9


def test_names_are_unique_also_beside_household():
    names = Counter(item.name for item in [*variety(), *household()])
    assert max(names.values()) == 1


def test_objects_are_sound():
    assert flaws(variety()) == {}


def test_sizes_are_plausible():
    assert odd_sizes(variety(), SIZES) == {}


def floating(objects) -> list[str]:
    """Return the names of objects of which a group of pieces that touch, within 2 mm, does not stand on the ground."""
    found = []
    for item in objects:
        groups, group, lows = pieces_that_touch(item.mesh)
        # A splayed leg's foot is turned with the leg, so its edge is up to 5 mm below the benches beside it.
        if not all(lows[group == k].min() < 0.005 for k in range(groups)):
            found.append(item.name)
    return found


def test_nothing_floats():
    assert floating(variety()) == []


def test_cups_are_hollow_and_open():
    """A line down the middle of its rim meets nothing above the floor, 2.5 cm and a quarter of the height down."""
    for item in labelled(variety(), "cup"):
        mesh = item.mesh
        height = mesh.extents[2]
        rim = mesh.vertices[mesh.vertices[:, 2] > 0.97 * height]
        middle = (rim.min(axis=0) + rim.max(axis=0)) / 2
        near = np.linalg.norm(mesh.triangles_center[:, :2] - middle[:2], axis=1) < 0.3 * np.ptp(rim[:, 0])
        floor = mesh.triangles_center[near, 2].max()
        assert height - floor > max(0.025, 0.25 * height), item.name


def test_tables_have_one_level_to_put_things_on():
    """Within two centimetres of one height lie at least as much level surface as a tray has, at a table's height."""
    for item in labelled(variety(), "table"):
        area = level_area(item.mesh, 0.2, 1.2, steepest_deg=5)
        assert (area[:-1] + area[1:]).max() > 0.05, item.name


def test_seats_have_room_for_one():
    """Surfaces within 30 degrees of level below 0.85 m have room for one: 20 by 20 cm, a swing's board 15 by 36."""
    for item in labelled(variety(), "sittable"):
        if item.category != "wire_chair":  # whose seat is a net
            assert level_area(item.mesh, 0.0, 0.85, steepest_deg=30).sum() > 0.04, item.name


@pytest.mark.parametrize("seed", [1, 3, 12345])
def test_another_seed_makes_other_objects_as_sound(seed):
    others = variety_objects(seed)
    assert unchanged(others, variety()) == []
    assert flaws(others) == {} and odd_sizes(others, SIZES) == {} and floating(others) == []


def test_same_seed_gives_the_same_meshes_bit_for_bit():
    assert identical(variety_objects(0), variety())


def test_stretching_leaves_objects_closed_and_on_the_ground():
    for item in stretched(variety()[::9], 0.15, seed=4):
        assert item.mesh.is_watertight == item.watertight and abs(item.mesh.bounds[0, 2]) < 1e-9


def test_it_is_a_catalogue_by_name():
    assert len(open_dataset("variety").objects) == len(variety())
