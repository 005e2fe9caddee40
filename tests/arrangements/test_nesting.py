"""How far one object goes down into another, and which of the two stands on which, against geometry."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.arrangements.placing import Placement
from spherefunc_bullet.scenes.arrangements.supports import GROUND, require_carried
from spherefunc_bullet.scenes.arrangements.together import put_down, without

EXACT = 1e-3  # metres; of meshes all of them are within a tenth of it


def cup(half_deg: float, foot: float = 0.03, wall: float = 0.002, height: float = 0.1) -> trimesh.Trimesh:
    """Return a conical cup: half its angle, the radius of its foot, its wall along the ground and its floor, metres."""
    slope = np.tan(np.radians(half_deg))
    rim = foot + slope * height
    inner = [[rim - wall, height], [foot - wall + slope * wall, wall], [0, wall]]
    return trimesh.creation.revolve(np.array([[0, 0], [foot, 0], [rim, height], *inner]), sections=48)


def tray(width: float, depth: float, height: float, wall: float) -> trimesh.Trimesh:
    """Return an open box of walls and a floor of one thickness, on the ground, metres."""
    sides = [((width, wall), (0, (depth - wall) / 2)), ((wall, depth), ((width - wall) / 2, 0))]
    parts = [trimesh.creation.box((width, depth, wall)).apply_translation([0, 0, wall / 2])]
    for (along, across), (x, y) in sides:
        for sign in (1, -1):
            part = trimesh.creation.box((along, across, height))
            parts.append(part.apply_translation([sign * x, sign * y, height / 2]))
    return trimesh.util.concatenate(parts)


def put(*meshes: trimesh.Trimesh, points: bool = False, **place: float):
    """Return the first object on the ground, and the next set down over it, in turn."""
    clouds = [cloud_from_mesh(mesh.vertices, mesh.faces, f"object {k}") for k, mesh in enumerate(meshes)]
    clouds = [Cloud(cloud.points, cloud.name) for cloud in clouds] if points else clouds
    return put_down(clouds, [Placement(), *(Placement(**place) for _ in clouds[1:])])


def carriers(placed) -> list[tuple[str, ...]]:
    """Return what each object stands on."""
    found = []
    for number, item in enumerate(placed):
        others = without(placed, number)
        found.append(require_carried(item, others).carriers([other.name for other in others]))
    return found


@pytest.mark.parametrize("wall", [0.002, 0.004])
@pytest.mark.parametrize("half_deg", [3, 5, 10, 20])
def test_equal_cups_nest_by_their_walls(half_deg, wall):
    """One goes down until its wall, as thick along the ground, lies on the other's: wall / tan of half the angle."""
    placed = put(*[cup(half_deg, wall=wall)] * 2)
    assert placed[1].height == pytest.approx(wall / np.tan(np.radians(half_deg)), abs=EXACT)
    assert carriers(placed) == [(GROUND,), ("object 0",)]


@pytest.mark.parametrize("half_deg", [5, 10, 20])
def test_equal_cups_nest_whichever_way_they_face(half_deg):
    """Of 48 sides, one cup's corners meet the other's faces, which are nearer by 1 - cos of half a side's angle.

    And it turns about the middle of its samples, which is a fraction of a millimetre beside its axis.
    """
    slope, placed = np.tan(np.radians(half_deg)), put(*[cup(half_deg)] * 2, heading_deg=17.0)
    middle = placed[0].own.mesh.vertices[:, :2].min(axis=0) + placed[0].own.mesh.vertices[:, :2].max(axis=0)
    aside = 2 * np.sin(np.radians(17 / 2)) * np.linalg.norm(middle / 2)
    chord = (0.03 + 0.1 * slope) * (1 - np.cos(np.pi / 48))
    assert 0.002 / slope <= placed[1].height <= (0.002 + chord + aside) / slope + EXACT / 10


def test_a_narrower_cup_goes_down_to_the_floor():
    placed = put(cup(8, foot=0.03, wall=0.003), cup(8, foot=0.02))
    assert placed[1].height == pytest.approx(0.003, abs=EXACT)
    assert carriers(placed) == [(GROUND,), ("object 0",)]


def test_three_cups_stand_each_on_the_one_below():
    placed = put(*[cup(10)] * 3)
    assert [one.height for one in placed] == pytest.approx(np.arange(3) * 0.002 / np.tan(np.radians(10)), abs=EXACT)
    assert carriers(placed) == [(GROUND,), ("object 0",), ("object 1",)]


POT = np.array([[0, 0], [0.1, 0], [0.1, 0.12], [0.097, 0.12], [0.097, 0.003], [0, 0.003]])
LID = np.array([[0, 0], [0.09, 0], [0.09, 0.01], [0.105, 0.01], [0.105, 0.012], [0.09, 0.012], [0, 0.02]])


def pairs() -> dict[str, tuple[trimesh.Trimesh, trimesh.Trimesh, float]]:
    """Return pairs, and how high the second stands, metres."""
    pot, lid = (trimesh.creation.revolve(profile, sections=64) for profile in (POT, LID))
    brick = trimesh.creation.box((0.25, 0.15, 0.2)).apply_translation([0, 0, 0.1])
    upturned = cup(8).apply_transform(np.diag([1, -1, -1, 1]))
    return {
        "a lid on a pot": (pot, lid, 0.11),
        "a box in a box": (tray(0.3, 0.2, 0.1, 0.004), brick, 0.004),
        "a box across a box": (tray(0.3, 0.2, 0.1, 0.004), trimesh.creation.box((0.35, 0.1, 0.05)), 0.1),
        "a box on its like": (trimesh.creation.box((0.2, 0.2, 0.2)), trimesh.creation.box((0.2, 0.2, 0.2)), 0.2),
        "a cup on a cup's rim": (cup(8), upturned, 0.1),
    }


@pytest.mark.parametrize("points", [False, True])
@pytest.mark.parametrize("name", pairs())
@pytest.mark.slow
def test_what_is_stacked_stands_where_it_touches(name, points):
    below, above, height = pairs()[name]
    placed = put(below, above, points=points)
    slack = placed[0].own.spacing if points else EXACT  # of a rim of points, a square may stand out
    assert placed[1].height == pytest.approx(height, abs=slack)
    assert carriers(placed) == [(GROUND,), ("object 0",)]


def test_edges_that_cross_carry_each_other():
    """Two bars that stand on an edge: no corner of either is over or under a face of the other."""
    bar = trimesh.creation.box((0.5, 0.02, 0.02))
    bar.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 4, [1, 0, 0]))
    placed = put(bar, bar, heading_deg=90.0)
    assert placed[1].height == pytest.approx(0.02 * np.sqrt(2), abs=EXACT / 10)
    assert carriers(placed) == [(GROUND,), ("object 0",)]


@pytest.mark.parametrize(("half_deg", "wall"), [(5, 0.002), (5, 0.004), (10, 0.004), (20, 0.002)])
@pytest.mark.slow
def test_cups_of_points_nest_as_deep_as_their_points_can_tell(half_deg, wall):
    placed = put(*[cup(half_deg, wall=wall)] * 2, points=True)
    expected, aside = wall / np.tan(np.radians(half_deg)), 0.35 * placed[0].own.spacing
    assert placed[1].height == pytest.approx(expected, abs=aside / np.tan(np.radians(half_deg)))
    assert carriers(placed) == [(GROUND,), ("object 0",)]


def test_what_interpenetrates_carries_nothing():
    box, other = trimesh.creation.box((0.2, 0.2, 0.2)), trimesh.creation.box((0.3, 0.1, 0.1))
    with pytest.raises(InputError, match=r"what it interpenetrates \(object 0\) carries nothing"):
        carriers(put(box, box, x=0.05, z=0.19))
    assert carriers(put(box, other, z=0.0)) == [(GROUND,), (GROUND,)]


def test_a_box_on_the_lower_of_two_boards_stands_on_that():
    boards = [trimesh.creation.box((0.6, 0.3, 0.02)).apply_translation([0, 0, z]) for z in (0.21, 0.51)]
    sides = [trimesh.creation.box((0.02, 0.3, 0.6)).apply_translation([x, 0, 0.3]) for x in (-0.31, 0.31)]
    shelf = trimesh.util.concatenate([*boards, *sides])
    placed = put(shelf, trimesh.creation.box((0.2, 0.2, 0.25)), z=0.22)
    assert carriers(placed) == [(GROUND,), ("object 0",)]


@pytest.mark.parametrize("sunk", [-0.002, 0.0, 0.001])
def test_a_height_that_was_typed_need_not_be_exact(sunk):
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    assert carriers(put(box, box, z=0.2 - sunk)) == [(GROUND,), ("object 0",)]
