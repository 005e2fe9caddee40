# ruff: noqa: F811 (a fixture is an argument of the same name)
"""What a backend must keep that tells poses or stances, or carries objects; what it lacks is skipped."""

from __future__ import annotations

import time

import numpy as np
import pytest

from ..clouds.cloud import Cloud, cloud_from_mesh
from ..simulator import Simulator, provenance_of
from ..simulator.mechanics import CarrySettings, PoseSettings, Stance, StandSettings
from .test_simulator import pytest_generate_tests, simulator  # noqa: F401

BOX_FACES = np.array(
    [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6],
     [3, 0, 4], [3, 4, 7]]
)  # fmt: skip
SHARE = 0.06  # of 100 drops: by how much a share may be off theory
SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def prism(foot: float, top: float, height: float, shift: float = 0.0, lid: bool = True) -> Cloud:
    """Return a closed or open body between two level squares, the upper one shifted along x; sides in metres."""
    low, high = np.pad(SQUARE * foot, ((0, 0), (0, 1))), np.pad(SQUARE * top, ((0, 0), (0, 1)))
    high = high + [shift, 0, height]
    return cloud_from_mesh(np.concatenate([low, high]), BOX_FACES if lid else np.delete(BOX_FACES, [2, 3], axis=0))


def able(simulator: Simulator, ability: str) -> Simulator:
    """Return the simulator, or skip the test where it lacks an ability."""
    if not hasattr(simulator, ability):
        pytest.skip(f"{simulator.name} has no {ability!r}, which is optional")
    return simulator


def test_poses_of_a_cube_are_six_and_equally_likely(simulator: Simulator):
    """A cube lies on each of its faces as often, and rotations turn those down."""
    result = able(simulator, "poses").poses(prism(0.1, 0.1, 0.1), PoseSettings(), 0)
    assert len(result.poses) == 6
    assert np.allclose([pose.probability for pose in result.poses], 1 / 6, atol=SHARE)
    down = np.array([-pose.rotation[2] for pose in result.poses])
    assert np.allclose(np.abs(down).max(axis=1), 1, atol=1e-6) and len(np.unique(down.round(), axis=0)) == 6


def test_poses_say_what_made_them_and_repeat_bit_for_bit(simulator: Simulator):
    """The same arguments give the same bits, and the provenance is that of a drop."""
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
    """A prism of 20 cm whose top is shifted by more than its side has its weight beside its foot."""
    result = able(simulator, "stands").stands(prism(0.2, 0.2, 0.3, shift), StandSettings(), np.empty((0, 3)), 0)
    assert result.stance is stance and (result.margin > 0) == (stance is Stance.STANDS)


def test_a_load_beside_the_foot_tips(simulator: Simulator):
    """Ten times its own weight is carried over the foot and not at the rim of a top that is wider."""
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
    """The same arguments give the same centres, and the seconds are some of those that it took."""
    started = time.perf_counter()
    beaker, settings = prism(0.08, 0.1, 0.1, lid=False), CarrySettings(radius=0.01, spheres=15, angles_deg=(30.0,))
    first, again = (able(simulator, "carry").carry(beaker, settings, 2) for _ in range(2))
    assert first.centers.tobytes() == again.centers.tobytes() and first.kept == again.kept
    assert 0 < first.seconds < time.perf_counter() - started
