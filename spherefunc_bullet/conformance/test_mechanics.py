# ruff: noqa: F811 (a fixture is an argument of the same name)
"""Conformance tests of poses, stances, carrying and proofs of places; abilities that a backend lacks are skipped.

Places are proven on bodies whose use is known.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from ..clouds.cloud import Cloud, cloud_from_mesh
from ..simulator import Simulator, provenance_of
from ..simulator.mechanics import CarrySettings, PoseSettings, Stance, StandSettings
from ..simulator.proofs import REASONS, PourUse, ProofResult, ProofSettings, PutUse, SitUse, Use
from .test_simulator import pytest_generate_tests, simulator  # noqa: F401

BOX_FACES = np.array(
    [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6],
     [3, 0, 4], [3, 4, 7]]
)  # fmt: skip
SHARE = 0.06  # largest deviation of a share of 100 drops from theory
SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def prism(foot: float, top: float, height: float, shift: float = 0.0, lid: bool = True) -> Cloud:
    """Return a closed or open body between two horizontal squares, the upper one shifted along x; sides in metres."""
    low, high = np.pad(SQUARE * foot, ((0, 0), (0, 1))), np.pad(SQUARE * top, ((0, 0), (0, 1)))
    high = high + [shift, 0, height]
    return cloud_from_mesh(np.concatenate([low, high]), BOX_FACES if lid else np.delete(BOX_FACES, [2, 3], axis=0))


def able(simulator: Simulator, ability: str) -> Simulator:
    """Return the simulator, or skip the test where it lacks an ability."""
    if not hasattr(simulator, ability):
        pytest.skip(f"{simulator.name} has no {ability!r}, which is optional")
    return simulator


def test_poses_of_a_cube_are_six_and_equally_likely(simulator: Simulator):
    """A cube lies on each of its faces equally often, and the rotations turn these faces down."""
    result = able(simulator, "poses").poses(prism(0.1, 0.1, 0.1), PoseSettings(), 0)
    assert len(result.poses) == 6
    assert np.allclose([pose.probability for pose in result.poses], 1 / 6, atol=SHARE)
    down = np.array([-pose.rotation[2] for pose in result.poses])
    assert np.allclose(np.abs(down).max(axis=1), 1, atol=1e-6) and len(np.unique(down.round(), axis=0)) == 6


def test_poses_say_what_made_them_and_repeat_bit_for_bit(simulator: Simulator):
    """The same arguments give the same bits, and the provenance has the entries of a drop's."""
    cloud, settings, started = prism(0.1, 0.06, 0.15, shift=0.02), PoseSettings(drops=40), time.perf_counter()
    first, again = (able(simulator, "poses").poses(cloud, settings, 5) for _ in range(2))
    assert [pose.rotation.tobytes() for pose in first.poses] == [pose.rotation.tobytes() for pose in again.poses]
    assert [pose.probability for pose in first.poses] == [pose.probability for pose in again.poses]
    assert first.provenance == provenance_of(simulator, settings, 5)
    assert 0 < first.seconds < time.perf_counter() - started
    shares = [pose.probability for pose in first.poses]
    assert shares == sorted(shares, reverse=True) and sum(shares) <= 1 + 1e-9


@pytest.mark.parametrize(("shift", "stance"), [(0.0, Stance.STANDS), (0.12, Stance.STANDS), (0.4, Stance.TIPS)])
def test_what_leans_stands_while_its_weight_is_over_its_foot(simulator: Simulator, shift: float, stance: Stance):
    """The weight of a prism of 20 cm whose top is shifted by more than its side acts outside its foot."""
    result = able(simulator, "stands").stands(prism(0.2, 0.2, 0.3, shift), StandSettings(), np.empty((0, 3)), 0)
    assert result.stance is stance and (result.margin > 0) == (stance is Stance.STANDS)


def test_a_load_beside_the_foot_tips(simulator: Simulator):
    """A large load is carried above the foot, but not at the rim of a wider top."""
    places = np.array([[0.0, 0.0, 0.3], [0.25, 0.0, 0.3]])
    result = able(simulator, "stands").stands(prism(0.2, 0.5, 0.3), StandSettings(load=20.0), places, 0)
    assert result.carries.tolist() == [True, False]


def test_a_beaker_keeps_what_a_tray_does_not(simulator: Simulator):
    """Spheres of 1 cm stay behind a wall of 12 cm at 45 degrees, and leave a sheet with a rim of half their radius."""
    settings = CarrySettings(radius=0.01, spheres=20)
    beaker, tray = (
        able(simulator, "carry").carry(prism(side, side, height, lid=False), settings, 0)
        for side, height in ((0.08, 0.12), (0.2, 0.005))
    )
    assert beaker.kept[-1] > 0.7 and tray.kept[-1] < 0.1
    assert beaker.filled <= 20 and beaker.provenance["seed"] == 0


def test_carrying_repeats_bit_for_bit(simulator: Simulator):
    """The same arguments give the same centres, and the reported seconds are within those of the call."""
    started = time.perf_counter()
    beaker, settings = prism(0.08, 0.1, 0.1, lid=False), CarrySettings(radius=0.01, spheres=15, angles_deg=(30.0,))
    first, again = (able(simulator, "carry").carry(beaker, settings, 2) for _ in range(2))
    assert first.centers.tobytes() == again.centers.tobytes() and first.kept == again.kept
    assert 0 < first.seconds < time.perf_counter() - started


SEAT = 0.45  # metres, height of a seat
SIDES = 32
STEEP_DEG = 40.0  # friction of 0.6 holds up to 31 degrees


def verdicts(simulator: Simulator, cloud: Cloud, *uses: Use) -> list[ProofResult]:
    """Return the results of uses, after a check that exactly the failed ones give a reason."""
    found = able(simulator, "prove").prove(cloud, uses, ProofSettings(), 0)
    assert len(found) == len(uses)
    assert all((one.why in REASONS) != one.held for one in found)
    return found


def turned(*profile: tuple[float, float]) -> Cloud:
    """Return the surface of revolution about z of a profile of pairs of radius and height, metres."""
    angles = np.arange(SIDES) * 2 * np.pi / SIDES
    rings = [np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(SIDES, z)]) for r, z in profile]
    near, far = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    faces = [
        np.vstack([np.column_stack([a + near, a + far, b + far]), np.column_stack([a + near, b + far, b + near])])
        for a, b in ((SIDES * k, SIDES * (k + 1)) for k in range(len(profile) - 1))
    ]
    return cloud_from_mesh(np.vstack(rings), np.vstack(faces))


def sitting(height: float = SEAT) -> list[SitUse]:
    """Return the uses of a person who sits down above the origin, facing four directions."""
    return [SitUse(position=np.array([0.0, 0.0, height]), heading=quarter * np.pi / 2) for quarter in range(4)]


def ramp(degrees: float) -> Cloud:
    """Return a board, half a metre long and 2 cm thick, that slopes up along x from the ground."""
    slope = np.pad(SQUARE * 0.5, ((0, 0), (0, 1)))
    slope[:, 2] = np.tan(np.radians(degrees)) * slope[:, 0]
    return cloud_from_mesh(np.vstack([slope - [0, 0, 0.02], slope]), BOX_FACES)


def on_ramp(degrees: float) -> np.ndarray:
    """Return the pose of an object on the middle of a ramp."""
    angle, pose = np.radians(degrees), np.eye(4)
    pose[:3, 0], pose[:3, 2] = [np.cos(angle), 0, np.sin(angle)], [-np.sin(angle), 0, np.cos(angle)]
    pose[2, 3] = 0.02 + 0.25 * np.tan(angle)
    return pose


def test_a_box_is_sat_on_facing_every_way(simulator: Simulator):
    """A box 40 cm wide and 45 cm high is a stool."""
    assert all(one.held for one in verdicts(simulator, prism(0.4, 0.4, SEAT), *sitting()))


def test_nobody_sits_on_an_edge_nor_in_the_air(simulator: Simulator):
    """Neither the ridge of a roof with slopes of 45 degrees nor a box 30 cm too low is a seat."""
    assert not any(one.held for one in verdicts(simulator, prism(2 * SEAT, 0.002, SEAT), *sitting()))
    assert {one.why for one in verdicts(simulator, prism(0.4, 0.4, SEAT - 0.3), *sitting())} <= {"sank", "tipped"}


def test_a_plate_stays_on_a_level_board_and_slides_off_a_steep_one(simulator: Simulator):
    """It lies flat on both, but friction holds it on the first only."""
    plate = turned((1e-6, 0.0), (0.06, 0.0), (0.1, 0.015))
    for degrees, held in ((0.0, True), (STEEP_DEG, False)):
        (one,) = verdicts(simulator, ramp(degrees), PutUse(cloud=plate, pose=on_ramp(degrees)))
        assert one.held is held and (held or one.moved > 0.02)


def test_a_beaker_keeps_what_is_poured_and_a_tube_spills_it(simulator: Simulator):
    """They differ only in the bottom."""
    walls = ((0.04, 0.0), (0.04, 0.1))
    use = PourUse(
        position=np.array([0.0, 0.0, 0.14]),
        radius=0.04,
        volume=0.8 * np.pi * 0.04**2 * 0.1,
        low=np.array([-0.04, -0.04, 0.0]),
        high=np.array([0.04, 0.04, 0.1]),
    )
    (kept,) = verdicts(simulator, lifted(turned((1e-6, 0.0), *walls)), raised(use))
    (spilled,) = verdicts(simulator, lifted(turned(*walls)), raised(use))
    assert kept.held and spilled.why == "spilled"


def lifted(cloud: Cloud) -> Cloud:
    """Return an object 10 cm higher, held there by a thin post next to it."""
    post = np.vstack([SQUARE * 0.01 + [0.06, 0], SQUARE * 0.01 + [0.06, 0]])
    bars = np.column_stack([post, np.repeat([-0.1, 0.0], 4)])
    vertices = np.vstack([cloud.mesh.vertices, bars]) + [0, 0, 0.1]
    return cloud_from_mesh(vertices, np.vstack([cloud.mesh.faces, BOX_FACES + len(cloud.mesh.vertices)]))


def raised(use: PourUse) -> PourUse:
    """Return the use of a lifted object; clouds are centred, so the use moves with its object."""
    shift = np.array([-0.0125, 0.0, 0.1])
    return replace(use, position=use.position + shift, low=use.low + shift, high=use.high + shift)


@pytest.mark.parametrize("seed", [0, 3])
def test_proofs_repeat_bit_for_bit(simulator: Simulator, seed: int):
    """The same arguments give the same results, whatever was proven before."""
    box, prove = prism(0.4, 0.4, SEAT), able(simulator, "prove").prove
    alone = prove(box, sitting()[1:2], ProofSettings(), seed)
    assert alone == prove(box, sitting()[1:2], ProofSettings(), seed)
    assert prove(box, sitting(), ProofSettings(), seed) == prove(box, sitting(), ProofSettings(), seed)
