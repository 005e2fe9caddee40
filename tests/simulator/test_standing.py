"""Does it stand, and where can it carry a load? Against the moments about an edge, by statics and by the engine."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh
from objects_to_scan import slab_on_posts

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.compare.mechanics.standing import loaded_places
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_mass
from spherefunc_bullet.scenes.impairment.sawn import SAWN, copies_of, needed_legs
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.settling.resting_places import resting_places
from spherefunc_bullet.simulator import backend_entry_points, make_simulator
from spherefunc_bullet.simulator.mechanics import Material, Stance, StandSettings, able_backends
from spherefunc_bullet.simulator.statics.body import body_of
from spherefunc_bullet.simulator.statics.facets import facets_of

NOWHERE = np.empty((0, 3))


@pytest.fixture(scope="module", params=sorted(backend_entry_points()))
def simulator(request):
    if request.param not in able_backends("stands"):
        pytest.skip(f"{request.param} does not say whether objects stand")
    try:
        return make_simulator(request.param)
    except InputError as error:
        pytest.skip(str(error))


def cloud_of(mesh: trimesh.Trimesh) -> Cloud:
    return cloud_from_mesh(mesh.vertices, mesh.faces, "object")


def table() -> Cloud:
    """Return a table of 1.2 x 0.8 m, its feet 5 cm from the edges of the top."""
    return cloud_of(slab_on_posts(1.2, 0.8, 0.75))


def pedestal(top: float = 0.4, foot: float = 0.15, height: float = 0.7) -> Cloud:
    """Return a square top on a square column, half sides in metres: it tips over the foot's edges."""
    column = trimesh.creation.box((2 * foot, 2 * foot, height))
    plate = trimesh.creation.box((2 * top, 2 * top, 0.02))
    plate.apply_translation([0, 0, height / 2])
    return cloud_of(trimesh.util.concatenate([column, plate]))


def leaning(offset: float) -> Cloud:
    """Return a block that is sheared, so that its weight acts so far beside the middle of its foot of 20 cm, metres."""
    block = trimesh.creation.box((0.2, 0.2, 0.4))
    block.vertices[block.vertices[:, 2] > 0, 0] += 2 * offset
    return cloud_of(block)


def test_a_table_stands(simulator):
    result = simulator.stands(table(), StandSettings(), NOWHERE)
    assert result.stance is Stance.STANDS and result.tilt_deg < 0.1 and result.share is None


@pytest.mark.parametrize("offset", [0.0, 0.07, 0.093])
def test_a_block_stands_while_its_weight_acts_within_its_foot(simulator, offset):
    result = simulator.stands(leaning(offset), StandSettings(), NOWHERE)
    assert result.stance is Stance.STANDS
    assert result.margin == pytest.approx(0.1 - offset, abs=0.003)  # the sides that lean have more surface


@pytest.mark.parametrize("offset", [0.11, 0.15])
def test_a_block_tips_when_its_weight_acts_beyond_its_foot(simulator, offset):
    result = simulator.stands(leaning(offset), StandSettings(), NOWHERE)
    assert result.stance is Stance.TIPS and result.tilt_deg > 40 and result.margin < 0


def test_a_load_tips_where_moments_about_the_edge_say(simulator):
    cloud, edge = pedestal(), 0.15
    mass = simulator.stands(cloud, StandSettings(), NOWHERE).mass
    load = mass  # as heavy as itself, so that the common weight acts half way out: it tips beyond twice the edge
    places = np.array([[x, 0.0, 0.7] for x in (0.1, 0.28, 0.32, 0.39)])
    result = simulator.stands(cloud, StandSettings(load=load), places)
    assert result.carries.tolist() == [True, True, False, False]
    expected = [np.inf, *(mass * edge / (x - edge) for x in (0.28, 0.32, 0.39))]
    assert result.tipping_load == pytest.approx(expected, rel=1e-6)


def round_pedestal(top: float = 0.3, foot: float = 0.06, height: float = 1.1) -> Cloud:
    """Return a round top on a slender column, radii in metres."""
    sizes = ((foot, height), (top, 0.02))
    column, plate = (trimesh.creation.cylinder(radius, tall, sections=48) for radius, tall in sizes)
    return cloud_of(trimesh.util.concatenate([column, plate.apply_translation([0, 0, height / 2])]))


@pytest.mark.parametrize(("cloud", "foot", "top"), [(pedestal(), 0.15, 0.4), (round_pedestal(), 0.06, 0.3)])
def test_no_place_carries_a_load_above_its_tipping_load(simulator, cloud, foot, top):
    places = np.pad(np.linspace(foot, top, 60)[:, None], ((0, 0), (0, 2)))
    result = simulator.stands(cloud, StandSettings(load=20.0), places)
    assert result.carries.tolist() == (result.tipping_load >= 20.0).tolist()
    assert 0 < result.carries.sum() < 60


def test_the_engine_lets_fall_what_has_its_weight_beyond_its_foot():
    """By 2 to 14 mm, where friction of rolling held it; and keeps what has it well within, a contact or two aside."""
    bodies = pytest.importorskip("spherefunc_bullet.bullet.bodies.falling")
    pytest.importorskip("pybullet")
    for cloud, foot, top in ((pedestal(), 0.15, 0.7), (round_pedestal(), 0.06, 1.1)):
        body = body_of(cloud, Material())
        beyond = np.array([-0.03, 0.002, 0.005, 0.014])
        heavy = [body.loaded(20.0, np.array([(foot + one) * (20 + body.mass) / 20, 0, top])) for one in beyond]
        stances = [stand.stance for stand in bodies.release(heavy, StandSettings())]
        assert [stance is Stance.STANDS for stance in stances] == (beyond < 0).tolist()


def test_no_part_of_a_foot_is_a_rest_where_the_weight_acts_beyond_the_foot():
    """A square foot is two triangles: the weight may be on the inner side of the one's edges, and beyond the foot."""
    facets = facets_of(body_of(leaning(0.15), Material()))
    assert not (facets.normals[facets.stable][:, 2] < -0.99).any()
    assert (facets_of(body_of(leaning(0.05), Material())).normals[:, 2] < -0.99).any()


@pytest.mark.parametrize(
    ("cloud", "words"),
    [
        (table(), "no load tips it"),  # at a place over its feet
        (pedestal(), "tips from 7.1 kg"),  # 11.8 kg with its edge at 15 cm, 25 cm beyond that
    ],
)
def test_what_tips_it_is_said_in_words(simulator, cloud, words):
    result = simulator.stands(cloud, StandSettings(load=5.0), np.array([[0.4, 0.0, 0.7]]))
    assert result.tipping_words == words
    assert simulator.stands(leaning(0.15), StandSettings(load=5.0), np.zeros((1, 3))).tipping_words == ""


def test_a_load_beyond_all_sense_is_no_load(simulator):
    """A third of a millimetre beyond the edge of the foot, moments say six tons, as a formula may."""
    result = simulator.stands(pedestal(), StandSettings(load=5.0), np.array([[0.1503, 0.0, 0.7]]))
    assert 1000 < result.tips_from < np.inf and result.tipping_words == "no load tips it"


def test_a_ball_rolls_and_a_cylinder_on_its_side_rolls(simulator):
    lying = trimesh.creation.cylinder(0.05, 0.3, sections=64)
    lying.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    for mesh in (trimesh.creation.icosphere(3, 0.1), lying):
        assert simulator.stands(cloud_of(mesh), StandSettings(), NOWHERE).stance is Stance.ROLLS


def test_a_chair_that_came_leaning_is_loaded_as_it_stands(simulator):
    """Its feet are level with each other, but the file has it turned by 2 degrees, on two of them."""
    mesh = slab_on_posts(0.5, 0.5, 0.45)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(2), [1, 0, 0]))
    cloud = cloud_of(mesh)
    result = simulator.stands(cloud, StandSettings(load=75.0, most_places=20), resting_places(cloud))
    assert result.stance is Stance.ROCKS and result.tilt_deg == pytest.approx(2, abs=0.1)
    assert result.margin == pytest.approx(0.225, abs=0.003)  # the posts' outer edges are 2.5 cm from the top's
    over_feet = (np.abs(result.places[:, :2]) < 0.2).all(axis=1)
    assert over_feet.sum() > 10 and result.carries[over_feet].all()


def test_a_leg_that_nothing_depends_on_is_not_sawn():
    feet = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.75, 0.0], [0.5, 0.5]])
    over = np.random.default_rng(0).uniform(0, 1, size=(400, 2))
    assert needed_legs(feet, np.arange(1, 7), 6, over) == [1, 3, 4]  # the fifth foot stands in for the second
    assert needed_legs(feet[:4], np.arange(1, 5), 4, over) == [1, 2, 3, 4]
    assert needed_legs(feet[:4], np.arange(1, 5), 4, over[over.sum(axis=1) > 1]) == [2, 3, 4]  # nothing over the first


def test_a_load_acts_within_the_edge_of_the_seat():
    grid = np.stack(np.meshgrid(np.arange(0, 0.41, 0.01), np.arange(0, 0.41, 0.01), [0.45]), axis=-1).reshape(-1, 3)
    shelf = grid * [1, 1, 0.3]
    places = loaded_places(np.concatenate([grid, shelf[::3]]))
    assert places[:, 2] == pytest.approx(0.45)
    low, high = places[:, :2].min(), places[:, :2].max()
    assert (low, high) == pytest.approx((0.05, 0.35), abs=0.011)  # a step of the grid
    assert len(loaded_places(grid[:2])) == 2 and len(loaded_places(grid[:0])) == 0  # too few for an edge


def test_a_short_leg_rocks(simulator):
    mesh = slab_on_posts(1.2, 0.8, 0.75)
    foot = (mesh.vertices[:, 2] < 0.01) & (mesh.vertices[:, 0] > 0) & (mesh.vertices[:, 1] > 0)
    mesh.vertices[foot, 2] += 0.06
    # Put something on that corner, so that its weight acts beyond the other three feet.
    stone = trimesh.creation.box((0.3, 0.3, 0.5))
    stone.apply_translation([0.4, 0.2, 1.0])
    result = simulator.stands(cloud_of(trimesh.util.concatenate([mesh, stone])), StandSettings(), NOWHERE)
    assert result.stance is Stance.ROCKS and 1 < result.tilt_deg < 10


def test_sawing_a_leg_off_takes_half_of_the_places(simulator):
    whole = table()
    (kind, sawn), *_ = copies_of(Specimen(whole, "table"), "table", SAWN)
    assert kind.kind == "leg_sawn_off"
    settings = StandSettings(load=30.0, most_places=40)
    shares = [
        simulator.stands(cloud, settings, resting_places(cloud)).share
        for cloud in (whole, cloud_from_mesh(*sawn.mesh()))
    ]
    assert shares[0] == 1 and 0.3 < shares[1] < 0.75


def test_legs_cut_askew_lean():
    kinds = {kind.kind: surface for kind, surface in copies_of(Specimen(table(), "table"), "table", SAWN)}
    simulator = make_simulator("fast")
    result = simulator.stands(cloud_from_mesh(*kinds["legs_cut_askew"].mesh()), StandSettings(), NOWHERE)
    assert result.stance in (Stance.ROCKS, Stance.TIPS) and result.tilt_deg > 4


@pytest.mark.parametrize("seed", range(5))
def test_statics_and_the_engine_agree_on_bodies_of_any_shape(seed):
    if "bullet" not in able_backends("stands"):
        pytest.skip("PyBullet is not installed")
    points = np.random.default_rng(seed).normal(size=(25, 3)) * [0.1, 0.1, 0.15]
    cloud = cloud_of(trimesh.convex.convex_hull(points))
    fast, bullet = (make_simulator(name).stands(cloud, StandSettings(), NOWHERE) for name in ("fast", "bullet"))
    # What topples may roll farther by its speed, so only that it does not stay is the same.
    assert (fast.stance is Stance.STANDS) == (bullet.stance is Stance.STANDS)


def test_same_bits_again(simulator):
    places = resting_places(table())[:10]
    first, again = (simulator.stands(table(), StandSettings(load=30.0), places, 1) for _ in range(2))
    assert first.carries.tobytes() == again.carries.tobytes() and first.tilt_deg == again.tilt_deg


def test_a_heavier_table_carries_more(simulator):
    cloud, places = pedestal(), np.array([[0.35, 0.0, 0.7]])
    light, heavy = (
        simulator.stands(cloud, StandSettings(load=10.0, matter=Material(mass=mass)), places) for mass in (5.0, 50.0)
    )
    assert (light.carries[0], heavy.carries[0]) == (False, True)


@pytest.mark.parametrize("wrong", [{"load": -1}, {"tilt_deg": 0}, {"most_places": 0}, {"rocking_deg": 0.1}])
def test_settings_out_of_range_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        StandSettings(**wrong)


@pytest.mark.slow
def test_command_prints_json_and_draws(tmp_path):
    from typer.testing import CliRunner

    slab_on_posts(0.8, 0.6, 0.7).export(tmp_path / "table.ply")
    arguments = ["stand", str(tmp_path / "table.ply"), "--load", "5kg"]
    done = CliRunner().invoke(application(), [*arguments, "--json", "--picture", str(tmp_path / "table.png")])
    assert done.exit_code == 0, done.stderr
    (row,) = json.loads(done.stdout)
    assert row["provenance"]["backend"] == "fast"  # statics, unless another is asked
    assert row["stance"] == "stands" and row["load"] == 5 and 0 < row["carries"] <= 1
    table = CliRunner().invoke(application(), arguments).stdout
    assert f"tips from {format_mass(row['tipping_load'])}" in table
    assert len(row["places"]) > 20 and (tmp_path / "table.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("load", ["much", "-5kg", "0kg"])
def test_command_refuses_a_load_that_is_none(tmp_path, load):
    from spherefunc_bullet.formats.units import parse_mass

    with pytest.raises(InputError, match="mass"):
        parse_mass(load)
