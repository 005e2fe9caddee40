"""Places: what is known of boxes, cups and chairs by geometry comes out, whatever frame they are in."""

from __future__ import annotations

import importlib.util
import json
import sys
from dataclasses import replace
from itertools import cycle, product
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from checkout import ROOT
from commands import spherefunc

import spherefunc_bullet as sf
import spherefunc_bullet.places.finding as finding
from spherefunc_bullet.classification import failed_uses
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.places.finding import places_of, uses_of
from spherefunc_bullet.places.place import IDENTITY, Proof
from spherefunc_bullet.places.pouring import HOLE, pour_places
from spherefunc_bullet.places.regions import SEAT_CELL, HeightMap, seat_surface
from spherefunc_bullet.places.seats import has_no_place_to_sit, is_full_of_spikes, is_nowhere_level
from spherefunc_bullet.places.sitting import sit_places
from spherefunc_bullet.scenes.impairment.specimen import spike
from spherefunc_bullet.simulator.proofs import ProofSettings, PutUse, SitUse
from spherefunc_bullet.viewer.place_pictures import places_picture

SIDES = 48


def turned_shell(*profile: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface that pairs of radius and height make when they are turned about z."""
    angles = np.arange(SIDES) * 2 * np.pi / SIDES
    vertices = np.vstack(
        [np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(SIDES, z)]) for r, z in profile]
    )
    near, far = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    rings = [
        np.vstack([np.column_stack([a + near, a + far, b + far]), np.column_stack([a + near, b + far, b + near])])
        for a, b in ((SIDES * k, SIDES * (k + 1)) for k in range(len(profile) - 1))
    ]
    return vertices, np.vstack(rings)


def boxes(*corners: tuple) -> tuple[np.ndarray, np.ndarray]:
    """Return boxes, each from its lowest to its highest corner, as one mesh."""
    import trimesh

    parts = [trimesh.creation.box(bounds=np.reshape(box, (2, 3))) for box in corners]
    mesh = trimesh.util.concatenate(parts)
    return np.array(mesh.vertices), np.array(mesh.faces)


CUP = turned_shell((1e-6, 0), (0.04, 0), (0.04, 0.1))
TABLE = boxes((-0.6, -0.4, 0.70, 0.6, 0.4, 0.73), (-0.05, -0.05, 0, 0.05, 0.05, 0.7))
CHAIR = boxes(
    (-0.22, -0.22, 0.42, 0.22, 0.22, 0.45),
    (-0.22, -0.22, 0.45, -0.19, 0.22, 0.95),
    *[(x - 0.02, y - 0.02, 0, x + 0.02, y + 0.02, 0.42) for x in (-0.2, 0.2) for y in (-0.2, 0.2)],
)
PRISM = SIDES / 2 * np.sin(2 * np.pi / SIDES)  # area of the polygon that stands for a circle, in square radii
SEAT = {"sittable": 1.0}


@pytest.mark.parametrize(
    "profile, volume",
    [
        (((1e-6, 0), (0.04, 0), (0.04, 0.1)), PRISM * 0.04**2 * 0.1),
        (((1e-6, 0), (0.04, 0.1)), PRISM * 0.04**2 * 0.1 / 3),
        (((1e-6, 0), (0.045, 0), (0.045, 0.1), (0.04, 0.1), (0.04, 0.01), (1e-6, 0.01)), PRISM * 0.04**2 * 0.09),
    ],
    ids=["cylinder", "cone", "thick walls"],
)
def test_capacity_is_that_of_the_solid_of_revolution(profile, volume):
    """3 %: half a cell of the flood at the brim and at the bottom."""
    (place,) = pour_places(cloud_from_mesh(*turned_shell(*profile)))
    assert place.capacity_ml == pytest.approx(volume * 1e6, rel=0.03)


def test_a_saucer_does_not_add_to_its_cup():
    """The largest body of water is the cup's, whatever the saucer below it holds."""
    saucer, faces = turned_shell((1e-6, -0.01), (0.05, -0.01), (0.08, 0.01))
    both = np.vstack([CUP[0], saucer]), np.vstack([CUP[1], faces + len(CUP[0])])
    assert pour_places(cloud_from_mesh(*both))[0].capacity_ml == pytest.approx(PRISM * 160, rel=0.03)


def test_a_hole_in_the_wall_lets_out_what_is_above_it():
    """A ring without a wall at half the height leaves the lower half; no bottom leaves nothing."""
    vertices, faces = turned_shell((1e-6, 0), (0.04, 0), (0.04, 0.05), (0.04, 0.06), (0.04, 0.1))
    hole = (faces.min(axis=1) == 2 * SIDES) & (faces.max(axis=1) >= 3 * SIDES)
    assert hole.any()
    (place,) = pour_places(cloud_from_mesh(vertices, faces[~hole]))
    assert place.capacity_ml == pytest.approx(PRISM * 80, rel=0.05) and place.note == HOLE
    assert pour_places(cloud_from_mesh(*CUP))[0].note == ""
    assert not pour_places(cloud_from_mesh(CUP[0], CUP[1][2 * SIDES :]))


def test_levels_and_spilling_of_a_cylinder():
    """Half the volume stands at half the height; a tenth is spilled where the surface has sunk by that on one side."""
    (place,) = pour_places(cloud_from_mesh(*CUP))
    volumes, heights = np.transpose(place.levels)
    assert np.interp(volumes[-1] / 2, volumes, heights) == pytest.approx(0.05, abs=0.002)
    assert place.spill_tilt_deg == pytest.approx(np.degrees(np.arctan(0.1 * 0.1 / 0.04)), abs=1.5)


@pytest.mark.parametrize("points", [False, True])
@pytest.mark.parametrize("low", range(4))
def test_a_vessel_spills_over_its_low_wall(low, points):
    """Of four walls one is lower by 4 cm: over this one it spills, or where it meets the next."""
    tops = np.where(np.arange(4) == low, 0.06, 0.1)
    walls = [(0.046, -0.05, 0, 0.05, 0.05, tops[0]), (-0.05, 0.046, 0, 0.05, 0.05, tops[1])]
    walls += [(-0.05, -0.05, 0, -0.046, 0.05, tops[2]), (-0.05, -0.05, 0, 0.05, -0.046, tops[3])]
    cloud = cloud_from_mesh(*boxes((-0.05, -0.05, 0, 0.05, 0.05, 0.004), *walls))
    (place,) = pour_places(Cloud(cloud.points) if points else cloud)
    assert abs((place.spill_heading_deg - 90 * low + 180) % 360 - 180) <= 46


def test_a_chair_is_sat_on_at_its_seat_away_from_its_back():
    """The back is on the left, so the sitter faces +x."""
    seat = next(place for place in places_of(cloud_from_mesh(*CHAIR), scores=SEAT) if place.kind == "sit")
    assert seat.height == pytest.approx(0.45, abs=0.01) and seat.back and not seat.arms
    assert abs((seat.heading_deg + 180) % 360 - 180) < 10


def test_a_stool_is_sat_on_from_all_sides():
    """Without a back there is no heading."""
    stool = cloud_from_mesh(*boxes((-0.2, -0.2, 0.42, 0.2, 0.2, 0.45), (-0.03, -0.03, 0, 0.03, 0.03, 0.42)))
    seat = next(place for place in places_of(stool, scores=SEAT) if place.kind == "sit")
    assert seat.heading_deg is None and not seat.back


def test_a_seat_is_as_deep_as_its_shorter_side_if_one_sits_facing_any_way():
    """To within a cell at each end; some of these persons sit along the diagonal, which is longer."""
    for depth, width in ((0.35, 0.35), (0.35, 0.9)):
        bench = cloud_from_mesh(*boxes((-depth / 2, -width / 2, 0, depth / 2, width / 2, 0.45)))
        seats = [place for place in places_of(bench, scores=SEAT) if place.kind == "sit" and place.heading_deg is None]
        assert seats and all(place.depth == pytest.approx(depth, abs=2 * SEAT_CELL) for place in seats)


@pytest.mark.parametrize(
    "height, half, sat", [(0.84, 0.2, True), (0.9, 0.2, False), (0.78, 0.35, True), (0.78, 0.5, False)]
)
def test_bar_stools_are_sat_on_and_what_is_higher_or_wider_is_not(height, half, sat):
    """A gas lift goes up to 86 cm, and a draughtsman's chair stands on five feet 70 cm across."""
    feet = [(-half, -0.03, 0, half, 0.03, 0.03), (-0.03, -half, 0, 0.03, half, 0.03)]
    stool = boxes((-0.2, -0.2, height - 0.03, 0.2, 0.2, height), (-0.03, -0.03, 0.03, 0.03, 0.03, height - 0.03), *feet)
    assert has_no_place_to_sit(cloud_from_mesh(*stool)) != sat


def test_nobody_sits_on_the_mouth_of_a_tube():
    """The cells around are of a seat's height, and there is nothing else: it was once a place ten metres down."""
    heights = np.full((40, 40), -np.inf)
    heights[19:22, 19:22] = 0.45
    heights[20, 20] = -np.inf
    assert not sit_places(HeightMap(np.zeros(2), 0.025, heights, 0.0), sittable=1.0)


def spiky_or_slatted(pitch: float, tall: float) -> Cloud:
    """Return a seat 45 cm high of pyramids side by side, so tall, or where they have no height of slats; metres."""
    near = np.arange(-0.25 + pitch / 2, 0.25, pitch)
    feet = boxes(*[(x, y, 0, x + 0.04, y + 0.04, 0.43) for x in (-0.25, 0.21) for y in (-0.25, 0.21)])
    if not tall:
        slats = boxes(*[(x - pitch / 4, -0.25, 0.42, x + pitch / 4, 0.25, 0.45) for x in near])
        return cloud_from_mesh(*joined(feet, slats))
    triangles = np.concatenate([spike(np.array([x, y]), pitch, 0.45 - tall, 0.45) for x in near for y in near])
    return cloud_from_mesh(*joined(feet, (triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))))


def joined(*meshes: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return several meshes as one."""
    before = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + first for (_, faces), first in zip(meshes, before[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


@pytest.mark.parametrize("pitch, tall, sat", [(0.05, 0.12, False), (0.1, 0.06, False), (0.06, 0.0, True)])
def test_nobody_sits_on_spikes_but_on_slats(pitch, tall, sat):
    """Pyramids side by side, all as high, would be level for whoever looks at the highest points alone."""
    cloud = spiky_or_slatted(pitch, tall)
    assert bool(sit_places(seat_surface(cloud), sittable=1.0)) == sat
    failed = failed_uses({"sittable"}, lambda name, check: check(cloud))
    assert [use.name for use in failed] == ["nowhere_to_sit", "spikes"] * (not sat)
    failed = failed_uses({"sittable"}, lambda name, check: check(Cloud(cloud.points)))
    assert [use.name for use in failed] == ["nowhere_to_sit", "level_nowhere"] * (not sat)
    assert not failed_uses({"table"}, lambda name, check: check(cloud))


def stool_with(*bodies: tuple[np.ndarray, np.ndarray]) -> Cloud:
    """Return a stool, its top of 40 x 40 cm at z = 0.45, with meshes on it."""
    top = boxes((-0.2, -0.2, 0.42, 0.2, 0.2, 0.45), (-0.1, -0.1, 0, 0.1, 0.1, 0.42))
    return cloud_from_mesh(*joined(top, *bodies))


def rods(pitch: float, thick: float, heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return upright rods at a pitch on such a top, metres, their heights in turn."""
    near = np.arange(-0.2 + pitch / 2, 0.2, pitch)
    places = [(x, y, tall) for (x, y), tall in zip(product(near, near), cycle(heights), strict=False)]
    half = thick / 2
    return boxes(*[(x - half, y - half, 0.45, x + half, y + half, 0.45 + tall) for x, y, tall in places])


@pytest.mark.parametrize(
    "bodies, spiky",
    [
        ([rods(0.05, 0.03, np.array([0.12]))], True),
        ([rods(0.04, 0.025, np.array([0.05, 0.2, 0.1]))], True),
        ([], False),
        ([boxes((-0.18, -0.18, 0.45, 0.1, 0.18, 0.75))], False),  # a bag, beside which nobody has room
        ([boxes(*[(x, -0.2, 0.45, x + 0.1, 0.2, 0.45 + z) for x, z in ((-0.2, 0.3), (0.1, 0.2))])], False),
    ],
)
def test_a_seat_is_full_of_spikes_but_not_of_things(bodies, spiky):
    assert is_full_of_spikes(stool_with(*bodies)) == spiky


def chair_points(bend: str = "", count: int = 8_000) -> np.ndarray:
    """Return points (N, 3) at random on a chair whose seat is level, or a ``roof`` or a ``slope`` of 35 degrees."""
    points = trimesh.sample.sample_surface(trimesh.Trimesh(*CHAIR, process=False), count, seed=0)[0]
    points[:, 2] -= points[:, 2].min()
    seat = np.abs(points[:, 2] - 0.44) < 0.03
    off = points[seat, 1] - points[:, 1].mean()
    rise = {"": 0.0, "roof": -np.abs(off), "slope": off}[bend]
    points[seat, 2] += np.tan(np.radians(35)) * rise
    return points


@pytest.mark.parametrize("count", [3_000, 8_000, 30_000])
def test_points_at_random_on_a_chair_have_a_place_to_sit_also_among_stray_ones(count):
    """Half of the cells as wide as twice the distance to the nearest point would be empty."""
    points = chair_points(count=count)
    stray = np.random.default_rng(0).uniform(points.min(axis=0), points.max(axis=0), (count // 50, 3))
    for cloud in (Cloud(points), Cloud(np.vstack([points, stray]))):
        assert [place.kind for place in places_of(cloud, scores=SEAT) if place.kind == "sit"] == ["sit"]
        assert not has_no_place_to_sit(cloud) and not is_nowhere_level(cloud)


@pytest.mark.slow
@pytest.mark.parametrize("bend", ["roof", "slope"])
def test_points_of_a_bent_seat_are_nowhere_level_over_a_hand(bend):
    bent = Cloud(chair_points(bend))
    assert has_no_place_to_sit(bent) and is_nowhere_level(bent)
    assert not sf.classify(bent).functions


def test_poses_keep_off_edges_and_off_what_stands_there():
    """A box in the middle of a table: all cups stand on the table, beside it."""
    laid = cloud_from_mesh(*boxes((-0.6, -0.4, 0.70, 0.6, 0.4, 0.73), (-0.1, -0.1, 0.73, 0.1, 0.1, 0.9)))
    poses = [pose for place in places_of(laid, put=cloud_from_mesh(*CUP)) for pose in place.poses]
    on_table = np.array([pose[:3, 3] for pose in poses if pose[2, 3] < 0.1])  # it stands on z = 0
    assert len(on_table) >= 20
    assert (np.abs(on_table[:, 0]) <= 0.56).all() and (np.abs(on_table[:, 1]) <= 0.36).all()
    assert (np.abs(on_table[:, :2]).max(axis=1) >= 0.14).all()


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_poses_are_in_the_unit_of_what_something_is_put_on(scale):
    cup = trimesh.Trimesh(*CUP).apply_translation([0.3, -0.2, 0.0])  # off the origin of its file, which is in metres
    table = trimesh.Trimesh(TABLE[0] * scale, TABLE[1])
    (place, *_) = sf.find_places(table, put=cup, units="m" if scale == 1 else "mm")
    own = np.append(scale * cup.bounds.mean(axis=0), 1)
    stood = np.array([pose @ own for pose in place.poses])[:, :3] / scale
    assert len(stood) > 3 and np.allclose(stood[:, 2], 0.73 + 0.05, atol=0.003)
    assert (np.abs(stood[:, :2]) <= [0.6 - 0.04, 0.4 - 0.04]).all()


def test_poses_in_json_put_down_an_object_that_is_far_from_its_origin():
    """At UTM coordinates, rotations of five decimals would put it down ten metres beside the table."""
    turned = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    corners, faces = boxes((-0.05, -0.03, 0, 0.05, 0.03, 0.2))
    away, table = corners + [500_000, 4_000_000, 100], (TABLE[0] @ turned.T, TABLE[1])
    places = sf.find_places(table, put=(away, faces), scores={"sittable": 0.0, "table": 1.0})
    top = next(place for place in places if place.kind == "put")
    for pose, written in zip(top.poses, top.as_json()["poses"], strict=True):
        exact, rounded = (np.array(T)[:3, :3] @ away.T + np.array(T)[:3, 3:] for T in (pose, written))
        assert np.abs(exact - rounded).max() < 1e-4
        assert rounded[2].min() == pytest.approx(0.73, abs=0.005)  # on the top, some millimetres above it


@pytest.mark.parametrize("walls, ways", [("lr", (90, 270)), ("blr", (270,)), ("bflr", ())])
def test_a_shelf_is_a_place_where_it_stands_open(walls, ways):
    """30 cm below a top of 60 x 30 cm; what is higher does not stand there; the way in is where there is no wall."""
    sides = {
        "b": (-0.3, 0.14, 0, 0.3, 0.15, 0.7),
        "f": (-0.3, -0.15, 0, 0.3, -0.14, 0.7),
        "l": (-0.3, -0.15, 0, -0.29, 0.15, 0.7),
        "r": (0.29, -0.15, 0, 0.3, 0.15, 0.7),
    }
    boards = [(-0.3, -0.15, z, 0.3, 0.15, z + 0.02) for z in (0.38, 0.7)]
    cupboard = cloud_from_mesh(*boxes(*boards, *[sides[wall] for wall in walls]))
    under = [place for place in places_of(cupboard) if place.kind == "put" and place.height < 0.5]
    assert len(under) == bool(ways)
    for place in under:
        assert place.height == pytest.approx(0.4, abs=0.005) and place.clearance == pytest.approx(0.3, abs=2e-4)
        assert place.heading_deg in ways
    tall = cloud_from_mesh(*boxes((-0.03, -0.03, 0, 0.03, 0.03, 0.35)))
    assert all(place.height > 0.5 for place in places_of(cupboard, put=tall) if place.kind == "put")


@pytest.mark.parametrize("free", [0.121, 0.125, 0.198])
def test_the_free_height_above_a_shelf_does_not_depend_on_how_high_it_is(free):
    """Boards whose undersides lie at any height in a layer of a centimetre; heights are exact to a tenth of a mm."""
    bottoms = 0.1 + (0.02 + free) * np.arange(4)
    rack = boxes(*[(-0.3, -0.15, z, 0.3, 0.15, z + 0.02) for z in bottoms], (-0.3, 0.14, 0, 0.3, 0.15, bottoms[-1]))
    shelves = [place for place in places_of(cloud_from_mesh(*rack)) if place.clearance is not None]
    assert sorted(place.height for place in shelves) == pytest.approx(bottoms[:3] + 0.02, abs=1e-3)
    assert [place.clearance for place in shelves] == pytest.approx([free] * 3, abs=2e-4)


def test_the_foot_of_a_round_table_is_no_shelf():
    outline = ((0.0, 0.0), (0.35, 0.0), (0.35, 0.01), (0.03, 0.05), (0.03, 0.7), (0.45, 0.72), (0.45, 0.74), (0, 0.74))
    table = cloud_from_mesh(*turned_shell(*outline), "table")
    put = [place for place in places_of(table, scores={}) if place.kind == "put"]
    assert [place.height for place in put] == [pytest.approx(0.74, abs=0.003)]


def test_a_region_has_a_hole_where_something_stands():
    """Its outline is the table's, the hole the box's."""
    laid = cloud_from_mesh(*boxes((-0.6, -0.4, 0.70, 0.6, 0.4, 0.73), (-0.1, -0.1, 0.73, 0.1, 0.1, 0.9)))
    largest = max((place for place in places_of(laid) if place.kind == "put"), key=lambda place: place.area)
    assert len(largest.region) == 2
    assert np.ptp(largest.region[1][:, 0]) == pytest.approx(0.2, abs=0.05)


def test_places_are_in_the_frame_and_units_of_the_input():
    """Millimetres with y up, and moved away: what was found in metres is found there."""
    import trimesh

    vertices = CHAIR[0][:, [1, 2, 0]] * 1000 + [5000, 300, -700]  # x, y, z become z, x, y: turned, not mirrored
    found = sf.find_places(trimesh.Trimesh(vertices, CHAIR[1]), scores=SEAT, units="mm", up="y")
    seat = next(place for place in found if place.kind == "sit")
    assert np.allclose(seat.normal, [0, 1, 0], atol=0.05)
    assert np.allclose(seat.position[:2], [5000, 750], atol=60) and seat.height == pytest.approx(450, abs=10)
    assert seat.heading_deg == pytest.approx(270, abs=10)  # about y from x: towards +z


def test_an_answer_knows_its_places():
    """The same as of `find_places` with the answer's scores."""
    cloud = cloud_from_mesh(*CUP)
    answer = sf.classify(cloud)
    assert [place.as_json() for place in answer.places] == [
        place.as_json() for place in sf.find_places(cloud, scores=answer.scores)
    ]


def test_bullet_proves_what_holds_and_says_why_not():
    """A chair carries a sitter, a cup beside a table's edge does not stay; the same call gives the same."""
    pytest.importorskip("pybullet")
    bullet = sf.make_simulator("bullet")
    seat = SitUse(position=np.array([-0.04, 0.0, 0.45]), heading=0.0)
    held, again = (bullet.prove(cloud_from_mesh(*CHAIR), [seat], ProofSettings())[0] for _ in range(2))
    assert held.held and held == again
    beside = np.eye(4)
    beside[:3, 3] = [0.61, 0, 0.73]
    (fallen,) = bullet.prove(
        cloud_from_mesh(*TABLE), [PutUse(cloud=cloud_from_mesh(*CUP), pose=beside)], ProofSettings()
    )
    assert not fallen.held and fallen.why == "tipped"


def test_nobody_sits_on_a_pole():
    """A person who sinks onto it stays upright, held by what presses into the body with many times its weight."""
    pytest.importorskip("pybullet")
    pole = boxes((-0.055, -0.015, 0.45, -0.025, 0.015, 0.75))
    chair = np.vstack([CHAIR[0], pole[0]]), np.vstack([CHAIR[1], pole[1] + len(CHAIR[0])])
    use = SitUse(position=np.array([-0.07, 0.0, 0.45]), heading=0.0)
    bare, (verdict,) = (
        sf.make_simulator("bullet").prove(cloud_from_mesh(*mesh), [use], ProofSettings()) for mesh in (CHAIR, chair)
    )
    assert bare[0].held and not verdict.held and verdict.why == "sharp"


def test_nobody_sits_without_a_seat():
    """Without its seat a chair's frame lets a sitter through."""
    pytest.importorskip("pybullet")
    frame = cloud_from_mesh(CHAIR[0][8:], CHAIR[1][12:] - 8)
    use = SitUse(position=np.array([-0.04, 0.0, 0.45]), heading=0.0)
    assert not sf.make_simulator("bullet").prove(frame, [use], ProofSettings())[0].held


def test_a_proven_vessel_keeps_what_is_poured():
    """The stream's spheres stay in a cup."""
    pytest.importorskip("pybullet")
    places = sf.find_places(cloud_from_mesh(*CUP), prove=True, scores={})
    proof = next(place for place in places if place.kind == "pour").proven
    assert proof.holds and proof.backend == "bullet"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_no_seed_spills_what_is_poured_into_a_deep_vessel(seed):
    """Spheres that overlapped where they left the spout threw each other out of a stein of 0.8 litres."""
    pytest.importorskip("pybullet")
    stein = cloud_from_mesh(*turned_shell((1e-6, 0), (0.039, 0), (0.039, 0.165)))
    (place,) = pour_places(stein)
    (verdict,) = sf.make_simulator("bullet").prove(stein, uses_of(place, None), ProofSettings(), seed)
    assert verdict.held and verdict.moved < 0.04


def test_one_kind_of_places_is_found_alone(monkeypatch):
    objects = [cloud_from_mesh(*mesh, "object") for mesh in (CUP, TABLE, CHAIR)]
    found = [places_of(cloud) for cloud in objects]
    for kind in ("sit", "put", "pour"):
        alone = [places_of(cloud, only=kind) for cloud in objects]
        of_kind = [[place for place in places if place.kind == kind] for places in found]
        assert any(alone) and json.dumps([[p.as_json() for p in places] for places in alone]) == json.dumps(
            [[p.as_json() for p in places] for places in of_kind]
        )
    monkeypatch.setattr(finding, "pour_places", None)  # takes most of the time
    places_of(objects[0], only="sit")


def test_the_middle_of_a_long_top_comes_before_its_ends_and_a_large_level_before_small_ones():
    top = boxes((-1.0, -0.4, 0.70, 1.0, 0.4, 0.73), *[(-1.0, y, 0.4, 1.0, y + 0.25, 0.45) for y in (-0.9, 0.65)])
    first, *benches = (place for place in places_of(cloud_from_mesh(*top)) if place.kind == "put")
    assert len(benches) == 2 and first.height == pytest.approx(0.33, abs=0.002)  # the benches are its ground
    assert np.allclose(first.position[:2], 0, atol=0.02)
    assert all(abs(place.position[0]) < 0.02 for place in benches)


def test_a_place_that_did_not_hold_is_drawn_and_printed_as_one():
    from spherefunc_bullet.viewer.place_pictures import did_not_hold

    places = [place for place in places_of(cloud_from_mesh(*CHAIR), scores=SEAT) if place.kind == "sit"]
    failed = replace(places[0], proven=Proof(backend="bullet", trials=1, held=0, why=("tipped",)))
    assert did_not_hold(failed) and not did_not_hold(places[0])
    drawn = [places_picture([("chair", CHAIR[0], [one])]) for one in (places[0], failed)]
    assert drawn[0] != drawn[1]


def test_a_person_is_drawn_on_the_seat_in_one_piece():
    """The lowest point of trunk and thighs touches the seat, soles touch the ground, and each limb joins another."""
    from spherefunc_bullet.viewer.place_pictures import person_points, seated_person

    place = next(place for place in places_of(cloud_from_mesh(*CHAIR), scores=SEAT) if place.kind == "sit")
    low = replace(place, height=0.40, position=np.array([0.0, 0.0, 0.40]), heading_deg=90.0)
    limbs = seated_person(low)
    points = person_points(limbs, 0.02)  # 2 cm apart on rods 3 cm wide and wider: 3 mm from the lowest point at most
    assert points[:, 2].min() == pytest.approx(0.0, abs=0.003) and points[:, 2].max() == pytest.approx(1.29, abs=0.02)
    assert points[points[:, 1] < 0.3, 2].min() == pytest.approx(0.40, abs=0.003)  # thighs are on the seat
    ends = [np.array([limb.start, limb.end]) for limb in limbs]
    for k, limb in enumerate(limbs):
        others = [(other, own) for other, own in zip(limbs, ends, strict=True) if other is not limb]
        assert any(other.holds(ends[k]).any() or limb.holds(own).any() for other, own in others)


@pytest.mark.parametrize("person", [1.1, 2.0])
def test_a_person_is_drawn_as_tall_as_asked(person, tmp_path):
    """The head is as high over the seat as the height asks, and the soles touch the ground all the same."""
    from spherefunc_bullet.viewer.place_pictures import TALL, person_points, seated_person, write_places_page

    cloud = cloud_from_mesh(*CHAIR)
    place = next(place for place in places_of(cloud, scores=SEAT) if place.kind == "sit")
    low = replace(place, height=0.25, position=np.array([0.0, 0.0, 0.25]))
    usual, other = (person_points(seated_person(low, tall), 0.01)[:, 2] for tall in (TALL, person))
    assert (other.max() - 0.25) / (usual.max() - 0.25) == pytest.approx(person / TALL, abs=0.01)
    assert other.min() == pytest.approx(0.0, abs=0.003)
    write_places_page([(cloud, IDENTITY, [place])], tmp_path / "page.html", person)
    assert f"a person {person:g} m tall" in (tmp_path / "page.html").read_text()


def test_the_page_leaves_out_places_of_functions_that_the_object_does_not_have(tmp_path):
    from spherefunc_bullet.viewer.place_pictures import write_places_page

    cloud, page = cloud_from_mesh(*CHAIR), tmp_path / "places.html"
    sit = next(place for place in places_of(cloud, scores=SEAT) if place.kind == "sit")
    write_places_page([(cloud, IDENTITY, [sit, replace(sit, kind="put", score=0.02)])], page)
    text = page.read_text()
    assert "places to sit" in text and "places to put" not in text
    assert "Not shown: 1 place of functions that the object does not have." in text
    write_places_page([(cloud, IDENTITY, [replace(sit, score=0.0)])], page)
    assert "No place." in page.read_text()


def test_lengths_are_printed_with_their_unit_and_what_is_no_place_is_counted(capsys):
    from spherefunc_bullet.scenes.commands.places import print_places

    row = {"kind": "put", "heading_deg": None, "proven": None, "position": [-1e-4, 2.0, 450.0], "height": 450.0}
    row |= {"area": 9e4, "radius": 150.0, "poses": [np.eye(4)]}
    print_places([{"file": "top.ply", "places": [row | {"score": 0.9}, row | {"score": 0.0}]}], "mm")
    said = capsys.readouterr().out
    assert "lengths in mm" in said and "90000 mm² free, 300 mm wide, 1 pose\n" in said and "-0.00" not in said
    assert said.count("put") == 1 and "not shown, 1 place with a score below 0.05" in said


def test_fast_cannot_prove():
    """It says so before anything is computed."""
    with pytest.raises(sf.InputError, match="expected one that can"):
        sf.find_places(cloud_from_mesh(*CUP), prove=True, backend="fast")


@pytest.mark.parametrize("count", [None, 2000, 20_000])
def test_a_cloud_without_a_mesh_holds_about_as_much(count):
    """Points of a cylinder 4 mm apart, and points at random, between which there are gaps: walls have a thickness."""
    points = cloud_from_mesh(*CUP).points if count is None else at_random(*CUP, count)
    (place,) = pour_places(Cloud(points))
    assert place.capacity_ml == pytest.approx(PRISM * 160, rel=0.08)
    assert 0.1 <= place.height < 0.11


def test_a_flat_sheet_of_random_points_holds_no_water():
    """Its walls are as thick as the gaps, so it has pits between points."""
    sheet = [[0, 0, 0.7], [1, 0, 0.7], [1, 1, 0.7], [0, 1, 0.7]], [[0, 1, 2], [0, 2, 3]]
    assert not pour_places(Cloud(at_random(*sheet, 5000)))


def at_random(vertices: np.ndarray, faces: np.ndarray, count: int) -> np.ndarray:
    """Return points (N, 3) at random on a mesh, as many libraries sample it."""
    return trimesh.sample.sample_surface(trimesh.Trimesh(vertices, faces), count, seed=0)[0]


def test_the_command_prints_what_the_contract_names(tmp_path):
    """One JSON list on stdout; a bad file costs only itself and the exit code."""
    import trimesh

    trimesh.Trimesh(*CUP).export(tmp_path / "cup.ply")
    (tmp_path / "bad.ply").write_text("nothing")
    page = tmp_path / "places.html"
    answer = spherefunc("places", tmp_path / "cup.ply", tmp_path / "bad.ply", "--json", "--page", page)
    assert answer.returncode == 2
    assert "places to pour: 1" in page.read_text()
    (row,) = json.loads(answer.stdout)
    pour = next(place for place in row["places"] if place["kind"] == "pour")
    assert {
        "function",
        "position",
        "normal",
        "heading_deg",
        "region",
        "area",
        "height",
        "clearance",
        "score",
        "proven",
    } <= set(pour)


def example(name: str):
    """Return a script of the examples as a module."""
    path = ROOT / "examples" / "places" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_receptacles_for_habitat_are_the_top_without_what_stands_on_it(tmp_path):
    """As large as the region, level, in the object's frame with y up; what was in the configuration stays."""
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("shapely"), pytest.importorskip("mapbox_earcut")
    laid = boxes(
        (-0.6, -0.4, 0.70, 0.6, 0.4, 0.73), (-0.1, -0.1, 0.73, 0.1, 0.1, 0.9), (-0.05, -0.05, 0, 0.05, 0.05, 0.7)
    )
    trimesh.Trimesh(laid[0][:, [1, 2, 0]], laid[1]).export(tmp_path / "table.glb")
    config = tmp_path / "table.object_config.json"
    config.write_text(json.dumps({"render_asset": "table.glb", "mass": 20, "user_defined": {"note": "ours"}}))
    count = example("habitat_receptacles").add_receptacles(tmp_path / "table.glb", config)
    written = json.loads(config.read_text())
    assert written["mass"] == 20 and len(written["user_defined"]) == 1 + count == 3
    top = written["user_defined"]["receptacle_mesh_table_0"]
    mesh = trimesh.load(tmp_path / top["mesh_filepath"], force="mesh")
    assert top["up"] == [0, 1, 0] and np.ptp(mesh.vertices[:, 1]) < 0.005
    assert mesh.vertices[:, 1].mean() == pytest.approx(0.73, abs=0.005)
    assert mesh.area == pytest.approx(1.2 * 0.8 - 0.2 * 0.2, rel=0.08)  # edges are kept off


def test_the_sampler_for_blenderproc_sets_down_at_each_pose_once(tmp_path, monkeypatch):
    """Poses come from the command's JSON."""
    rows = [
        {"file": "table.ply", "places": [{"kind": "put", "poses": [np.diag([k, 1, 1, 1]).tolist() for k in (1, 2, 3)]}]}
    ]
    (tmp_path / "places.json").write_text(json.dumps(rows))
    monkeypatch.setitem(sys.modules, "blenderproc", SimpleNamespace())
    script, seen = example("blenderproc_sampler"), []
    set_down = script.sampler(script.read_poses(tmp_path / "places.json"))
    for _ in range(3):
        set_down(SimpleNamespace(set_local2world_mat=seen.append))
    assert sorted(pose[0, 0] for pose in seen) == [1, 2, 3]


@pytest.mark.parametrize("scores", [3, {"cup": "a"}, {"cup": 2.0}, {"cup": float("nan")}])
def test_scores_that_are_none_are_refused(scores):
    cloud = cloud_from_mesh(*turned_shell((0.0, 0.0), (0.04, 0.0), (0.04, 0.1)))
    with pytest.raises(InputError, match="score"):
        sf.find_places(cloud, scores=scores)
