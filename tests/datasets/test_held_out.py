"""Copies of kinds that no model learns: made when named only, useless in their own way, also as points."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh
from catalogues import household
from typer.testing import CliRunner

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.scenes.commands.dataset import app
from spherefunc_bullet.scenes.impairment.held_out import HELD_OUT, LEANING_DEG, ROOF_DEG
from spherefunc_bullet.scenes.impairment.impairments import COPIES, chosen_kinds
from spherefunc_bullet.scenes.impairment.levels import cut_away
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.scenes.impairment.surfaces import ObjectSurface
from spherefunc_bullet.settling.settling import mesh_leaks

KINDS = {each.kind for each in HELD_OUT}


@pytest.fixture(scope="module")
def specimens() -> dict[str, Specimen]:
    """A mug, a chair and a table, by label."""
    chosen = [item for item in household() if item.name in ("mug_01", "shell_chair_01", "dining_table_01")]
    clouds = {item.label: cloud_from_mesh(item.mesh.vertices, item.mesh.faces) for item in chosen}
    return {label: Specimen(cloud, label) for label, cloud in clouds.items()}


def changed(target: Specimen, kind: str) -> ObjectSurface:
    """Return a copy of one kind."""
    each = next(each for each in HELD_OUT if each.kind == kind and target.function in each.functions)
    return each.applied(target, "object", 0)


def cloud_of(surface: ObjectSurface) -> Cloud:
    return cloud_from_mesh(*surface.mesh())


def test_no_model_learns_them():
    assert not KINDS & {each.kind for each in COPIES}
    assert {each.kind for each in chosen_kinds(None)} == {each.kind for each in COPIES}
    assert {each.kind for each in chosen_kinds(["roof", "half_bottom"])} == {"whole", "roof", "half_bottom"}


def test_water_runs_out_of_a_cup_with_half_a_bottom_and_half_is_left(specimens):
    cup = specimens["cup"]
    assert not mesh_leaks(cup.cloud)
    half = changed(cup, "half_bottom")
    assert mesh_leaks(cloud_of(half))
    floors = [
        surface.centres[cup.cavity.distances(surface.centres) < 0.5 * cup.cavity.radii[0]]
        for surface in (cup.surface, half)
    ]
    whole, left = (len(np.unique(np.column_stack(cup.cavity.grid.cells_of(floor)), axis=0)) for floor in floors)
    assert 0.35 < left / whole < 0.65


def test_a_roof_slopes_to_both_sides(specimens):
    table = specimens["table"]
    roof, rest = changed(table, "roof"), cut_away(table.surface, table.level)
    mesh = trimesh.Trimesh(*roof.mesh(), process=False)
    above = mesh.triangles_center[:, 2] > rest.bounds[1, 2] + 1e-3
    normals, areas = mesh.face_normals[above], mesh.area_faces[above]
    slopes = np.degrees(np.arccos(np.abs(normals[:, 2])))
    sloping = np.isclose(slopes, ROOF_DEG, atol=1)
    across = int((table.level.box[1] - table.level.box[0]).argmin())
    sides = [areas[sloping & (side * normals[:, across] * np.sign(normals[:, 2]) > 0.5)].sum() for side in (-1, 1)]
    assert sides[0] == pytest.approx(sides[1], rel=0.1)
    assert areas[slopes < ROOF_DEG - 1].sum() < 0.1 * sum(sides)  # pieces across the ridge


@pytest.mark.parametrize("label", ["sittable", "table"])
def test_what_leans_or_has_toppled_is_turned_only(specimens, label):
    target = specimens[label]
    area = trimesh.Trimesh(*target.surface.mesh(), process=False).area
    for kind, degrees in (("leaning", LEANING_DEG), ("toppled", 90.0)):
        copy = trimesh.Trimesh(*changed(target, kind).mesh(), process=False)
        assert copy.area == pytest.approx(area) and copy.bounds[0, 2] == pytest.approx(0, abs=1e-9)
        largest = trimesh.Trimesh(*target.surface.mesh(), process=False).area_faces.argmax()
        assert np.degrees(np.arccos(abs(copy.face_normals[largest, 2]))) == pytest.approx(degrees, abs=1e-3)


def test_a_toppled_chair_does_not_lie_on_its_back(specimens):
    chair = specimens["sittable"]
    wide = chair.surface.size[abs(chair.back).argmin()]
    assert changed(chair, "toppled").size[2] == pytest.approx(wide)


def test_a_seat_slopes_and_a_folded_one_is_flat(specimens):
    chair = specimens["sittable"]
    assert changed(chair, "sloping") is not None
    assert min(changed(chair, "folded").size[:2]) == pytest.approx(0.1)


@pytest.mark.slow
def test_copies_are_points_on_their_triangles(tmp_path):
    command = ["impair", "household", str(tmp_path), "--copied", "1", "--kinds", "toppled,half_bottom"]
    made = {}
    for folder, more in (("meshes", []), ("points", ["--points", "3000"]), ("again", ["--points", "3000"])):
        command[2] = str(tmp_path / folder)
        result = CliRunner().invoke(app, [*command, *more, "--json"])
        assert result.exit_code == 0, result.output
        made[folder] = json.loads(result.stdout)["made"]
    assert made["points"] == made["meshes"] and made["points"]["table toppled"] == 1
    for path in sorted((tmp_path / "points").glob("*.ply")):
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes()
        points, mesh = load_cloud(path), trimesh.load_mesh(tmp_path / "meshes" / path.name)
        assert points.mesh is None and len(points) == 3000
        raw = trimesh.load(path).vertices
        assert trimesh.proximity.closest_point(mesh, raw[:300])[1].max() < 1e-4  # metres; inexact on slivers
