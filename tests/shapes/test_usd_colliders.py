"""Colliders of USD stages: what is made of them, and which functions they keep."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_shapes import cup
from typer.testing import CliRunner
from usd_stages import stage_of

import spherefunc_bullet as sf
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.shapes.loaded import FileFrame, load_solids

pytest.importorskip("pxr", reason="usd-core is not installed")

FRAME = FileFrame(up="z", units="m", shift=np.zeros(3))
BODY = ' (prepend apiSchemas = ["PhysicsRigidBodyAPI"])'
FLOOR = """    def Cube "Floor" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {
        token visibility = "invisible"
        double size = 0.1
        %s
    }"""


@pytest.fixture
def stage(tmp_path):
    """Return a function that writes a stage of a cup."""

    def write(approximation: str = "", body: str = "", beside: str = "", **frame) -> Path:
        path = tmp_path / "mug.usda"
        path.write_text(stage_of(cup(), approximation, body, beside, **frame))
        return path

    return write


def solid_of(path):
    (solid,) = load_solids(path, FRAME)
    return solid


def test_what_moves_collides_as_its_hull_unless_it_says_pieces(stage):
    assert solid_of(stage("none")).pieces is None
    for approximation in ("none", "convexHull"):
        moving = solid_of(stage(approximation, BODY))
        assert moving.count == 1 and moving.name == "/Mug"
    still = 'bool physics:kinematicEnabled = true\n    def Scope "Rest"\n    {\n    }'
    assert solid_of(stage("none", BODY, still)).pieces is None
    assert solid_of(stage("sdf", BODY)).pieces is None
    assert solid_of(stage("convexHull")).name == "mug"


def test_a_mesh_to_be_decomposed_is_of_pieces(stage):
    pytest.importorskip("vhacdx", reason="V-HACD is not installed")
    solid = solid_of(stage("convexDecomposition", BODY))
    assert 4 < solid.count <= 32


def test_boxes_and_spheres_surround_the_mesh(stage):
    box, ball = solid_of(stage("boundingCube", BODY)), solid_of(stage("boundingSphere", BODY))
    assert len(box.vertices) == 8 and np.allclose(np.ptp(box.vertices, axis=0), cup().extents, atol=1e-6)
    assert np.ptp(ball.vertices, axis=0).min() > cup().extents.max()
    assert np.allclose(box.vertices.mean(axis=0), ball.vertices.mean(axis=0), atol=1e-3)


def test_units_axes_and_parts_that_are_not_seen_are_followed(stage):
    alone = solid_of(stage("convexHull", BODY))
    other = solid_of(stage("convexHull", BODY, up="Y", metres=0.01))
    assert np.allclose(alone.vertices.max(axis=0), other.vertices.max(axis=0), atol=1e-5)
    assert solid_of(stage("convexHull", BODY, FLOOR % "")).count == 2
    assert solid_of(stage("convexHull", BODY, FLOOR % "bool physics:collisionEnabled = false")).count == 1


def test_another_approximation_is_refused(stage):
    with pytest.raises(InputError, match=r"^mug\.usda: expected a collider approximated as none, .*'sphereFill'"):
        solid_of(stage("sphereFill", BODY))


@pytest.mark.slow
def test_the_hull_of_a_mug_holds_nothing(stage):
    row, *_ = sf.compare_shapes(stage("convexHull", BODY), shapes=False).rows
    assert row.name == "/Mug" and row.capacity_kept == 0 and not row.keeps


@pytest.mark.slow
def test_a_stage_without_colliders_has_candidates_alone(stage, few_candidates):
    lines = []
    compared = sf.compare_shapes(stage(), report=lines.append)
    assert lines == ["mug.usda: expected collision geometry, found none; only candidates are compared"]
    assert compared.rows[0].name == "mesh"
    shown = CliRunner().invoke(application(), ["shapes", str(stage()), "--only-collision"])
    assert shown.exit_code == 2 and "expected collision geometry, found none" in shown.output
