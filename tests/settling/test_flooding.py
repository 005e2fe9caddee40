"""Where spheres stand in an object as water would: what a rim, a hole and a lid do to it."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy import ndimage

from spherefunc_bullet.clouds.flooding import CELL, basin_of, standing_in

RADIUS = 1.0
ROUND = 24.0  # radii across a tube's opening


def tube(height: float = 20.0, across: float = ROUND, sections: int = 64) -> trimesh.Trimesh:
    """Return an open tube with a floor, of single sheets."""
    turn = np.linspace(0, 2 * np.pi, sections, endpoint=False)
    ring = across / 2 * np.column_stack([np.cos(turn), np.sin(turn)])
    steps = np.linspace(0, height, 21)
    wall = [np.column_stack([ring, np.full(sections, z)]) for z in steps]
    k = np.arange(sections)
    n = (k + 1) % sections
    faces = [
        np.column_stack([corners + row * sections for corners in piece])
        for row in range(len(steps) - 1)
        for piece in ((k, n, k + sections), (n, n + sections, k + sections))
    ]
    floor = np.column_stack([k, n, np.full(sections, len(steps) * sections)])
    vertices = np.concatenate([*wall, [[0, 0, 0]]])
    return trimesh.Trimesh(vertices, np.concatenate([*faces, floor]), process=False)


def without(mesh: trimesh.Trimesh, center: tuple[float, float, float], radius: float) -> trimesh.Trimesh:
    """Return a mesh, its faces cut small, without those near a place."""
    vertices, faces = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, 0.5)
    far = np.linalg.norm(vertices[faces].mean(axis=1) - center, axis=1) > radius
    return trimesh.Trimesh(vertices, faces[far], process=False)


def basin(mesh: trimesh.Trimesh):
    return basin_of(np.asarray(mesh.vertices), np.asarray(mesh.faces), RADIUS)


def volume(mesh: trimesh.Trimesh) -> float:
    found = basin(mesh)
    return float(found.cells.sum() * found.cell**3)


def test_a_tube_holds_centres_up_to_a_radius_over_its_rim():
    """A centre leaves over the rim a radius above it, and is a radius from wall and floor, but for a cell or two."""
    reach, cell = ROUND / 2 - RADIUS, basin(tube()).cell
    assert np.pi * reach**2 * 20.0 < volume(tube()) < np.pi * (reach + 2 * cell) ** 2 * (20.0 + 3 * cell)
    assert basin(tube()).fullness == 1.0


@pytest.mark.parametrize("height", [5.0, 10.0, 15.0])
@pytest.mark.slow
def test_a_hole_shows_at_its_height(height):
    """What lies below the lowest point of a hole of two radii and a half stays: the centre passes a radius above it."""
    holed = basin(without(tube(), (ROUND / 2, 0, height), 2.5))
    assert holed.fullness == pytest.approx((height - 2.5) / 20, abs=0.06)


def test_a_hole_that_no_sphere_fits_through_holds():
    assert basin(without(tube(), (ROUND / 2, 0, 10.0), 0.7)).fullness == 1.0


def test_a_hole_in_the_floor_leaves_nothing_to_speak_of():
    assert basin(without(tube(), (0, 0, 0), 3.0)).fullness < 0.01


@pytest.mark.parametrize("mesh", [trimesh.creation.box((10, 10, 10)), trimesh.creation.box((20, 20, 0.01))])
def test_what_is_closed_or_flat_holds_nothing(mesh):
    assert not basin(mesh).holds(np.zeros((1, 3))).any() and volume(mesh) == 0


def test_of_two_hollows_the_larger_counts():
    """Spheres on a saucer are not in the cup: its rim is lower, and a wall is between them."""
    cup = tube(height=12.0, across=12.0)
    saucer = tube(height=2.0, across=30.0)
    found = basin(trimesh.util.concatenate([cup, saucer]))
    assert found.holds(np.array([[0, 0, 2.0]])).all()
    assert not found.holds(np.array([[10.0, 0, 1.2], [0, 10.0, 1.2]])).any()


def test_over_a_basin_is_above_it_and_not_under_a_flare():
    """A sphere on a saucer under a flaring wall has left the cup, though it lies within the outline of its rim."""
    flare = tube(height=12.0, across=12.0)
    flare.vertices[:, :2] *= 1 + flare.vertices[:, 2:] / 12.0
    found = basin(flare)
    over = found.over(0.6)
    asked = np.array([[0, 0, 40.0], [9.0, 0, 11.0], [9.0, 0, 1.0], [14.0, 0, 12.0]])
    assert found.known_of(over, asked).tolist() == [True, True, False, False]


def test_the_share_below_a_height_grows_evenly_in_a_tube():
    found = basin(tube())
    assert found.share_below(-5.0) == 0 and found.share_below(50.0) == 1
    assert found.share_below(11.0) == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("seed", range(5))
def test_the_flood_is_what_drains_level_by_level(seed):
    """Beside the definition: a cell drains if, of the cells no higher than it, some path leads to the outermost."""
    rng = np.random.default_rng(seed)
    solid = np.pad(rng.random((7, 8, 9)) < 0.6, 1)
    outside, _ = ndimage.label(~solid)
    open_cells = outside == outside[0, 0, 0]
    expected = np.zeros_like(solid)
    for height in range(solid.shape[2]):
        below, _ = ndimage.label(open_cells[:, :, : height + 1])
        faces = [below[0], below[-1], below[:, 0], below[:, -1], below[:, :, 0]]
        drained = np.isin(below[:, :, height], np.unique(np.concatenate([face.ravel() for face in faces])))
        expected[:, :, height] = open_cells[:, :, height] & ~drained
    assert expected.any() and np.array_equal(standing_in(solid), expected)


def test_larger_spheres_are_told_by_the_same_cells():
    """Lengths are in no unit: what is twice as large with spheres twice as large is the same."""
    mesh = without(tube(), (ROUND / 2, 0, 10.0), 2.5)
    twice = basin_of(2 * np.asarray(mesh.vertices), np.asarray(mesh.faces), 2 * RADIUS)
    assert np.array_equal(twice.cells, basin(mesh).cells) and CELL < 1
