"""`spherefunc view`: the data it shows, the evidence, the pages, and how a browser draws them."""

from __future__ import annotations

import base64
import html
import io
import json
import re
import shutil
import sys
from dataclasses import replace

import clouds
import numpy as np
import pytest
from browser import document, draw, needs_browser
from PIL import Image
from typer.testing import CliRunner

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud, Mesh
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.commands.view import RADII, SPHERES_ACROSS
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.method import Method
from spherefunc_bullet.learning.reasons.cubes import cube_evidence, strongest_cubes
from spherefunc_bullet.settling.drops import DropsByRadius, resting_drops
from spherefunc_bullet.simulator import DropSettings, make_simulator
from spherefunc_bullet.viewer.data import Layer, Panel, clustered, display, histogram_cubes, quantised, thinned
from spherefunc_bullet.viewer.page import display_html, display_page
from spherefunc_bullet.viewer.pictures import fitting_radius
from spherefunc_bullet.viewer.recording import settled_drops

RADIUS = 0.02
# What a user might do, all of it at once; an error in any of it reaches the console.
CLICKS = """<script>
addEventListener("load", () => setTimeout(() => {
for (const box of document.querySelectorAll("input[type=checkbox]")) if (!box.checked) box.click();
for (const list of document.querySelectorAll("select")) {
  list.selectedIndex = list.options.length - 1; list.dispatchEvent(new Event("change"));
}
for (const canvas of document.querySelectorAll("canvas")) {
  canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
  canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -50, ctrlKey: true }));
  const at = { clientX: canvas.clientWidth / 2, clientY: 200, pointerId: 1 };
  canvas.dispatchEvent(new PointerEvent("pointermove", at));
}
}, 100));
</script>"""


def heap(count: int, seed: int, shift: float = 0.0) -> np.ndarray:
    """Return random centres (count, 3) as if spheres lay in a box of 0.6 m, metres."""
    return np.random.default_rng(seed).uniform([-0.3, -0.3, 0.1], [0.3, 0.2, 0.5], (count, 3)) + [shift, 0, 0]


def fallen(centers: np.ndarray) -> DropsByRadius:
    return {RADIUS: resting_drops(RADIUS, centers)}


def learnt(method: Method) -> CubeClassifier:
    """Return a classifier of full and nearly empty heaps."""
    settled = [fallen(heap(150 if i < 5 else 40, i)) for i in range(10)]
    model = CubeClassifier(radii=[RADIUS], method=method)
    return model.fit_settled(settled, ["cup"] * 5 + ["none"] * 5, [f"heap {i % 3}" for i in range(10)])


def shown(cloud: Cloud, centers: np.ndarray, radius: float = RADIUS) -> dict:
    """Return a display of one panel."""
    layer = Layer(radius=radius, centers=centers, cubes=histogram_cubes(centers, radius), note="")
    return display(cloud, [Panel(title="fast", layers=[layer])])


@pytest.mark.parametrize("neighbors, of_all", [((1,), False), ((1, 3), False), ((8,), True)])
def test_evidence_sums_to_the_difference_of_squared_distances(neighbors, of_all):
    model = learnt(Method(name="test", neighbors=neighbors, of_all=of_all))
    asked = fallen(heap(90, 77, shift=0.4))  # some of it where no training object had a sphere
    distances = model.distances([asked], RADIUS)[0]
    weights = model.neighbor_weights(distances, "cup")
    members = model.members_[:, 0]
    means = [np.average(distances[side] ** 2, weights=weights[side]) for side in (members, ~members)]
    cubes = cube_evidence(model, asked, "cup", RADIUS)
    assert cubes.speaks_for.sum() == pytest.approx(means[1] - means[0], rel=1e-9)
    assert cubes.counts.sum() == pytest.approx(90)


def test_strongest_cubes_speak_on_both_sides_and_their_shares_are_of_all():
    model = learnt(Method(name="test"))
    asked = fallen(heap(90, 77, shift=0.4))
    cubes = cube_evidence(model, asked, "cup", RADIUS)
    every = strongest_cubes(model, asked, "cup", len(cubes.counts))
    assert sum(abs(each["share"]) for each in every) == pytest.approx(1, abs=0.01)  # each is rounded
    few = strongest_cubes(model, asked, "cup", 2)
    assert [each["share"] > 0 for each in few] == [True, True, False, False]
    assert few[0]["share"] == max(each["share"] for each in every)
    assert few[2]["share"] == min(each["share"] for each in every)
    strongest = cubes.corners[np.argmax(cubes.speaks_for)]
    assert few[0]["corner"] == pytest.approx(strongest, abs=1e-6)


def test_weights_of_neighbours_are_those_that_classify_explains():
    model = learnt(Method(name="test"))
    asked = fallen(heap(90, 77))
    weights = model.neighbor_weights(model.distances([asked], RADIUS)[0], "cup")
    named = [row["weight"] for row in model.neighbors(asked, "cup")]
    assert np.allclose(np.sort(weights[weights > 0]), np.sort(named), atol=1e-4)  # those are rounded
    assert weights[model.members_[:, 0]].sum() == pytest.approx(model.score_settled([asked])[0, 0])


def test_with_one_neighbour_the_cubes_decide_as_the_classifier_does():
    model = learnt(Method(name="test", neighbors=(1,)))
    for seed, count in enumerate((20, 60, 90, 120, 200)):
        asked = fallen(heap(count, 50 + seed))
        total = cube_evidence(model, asked, "cup", RADIUS).speaks_for.sum()
        assert (total > 0) == (model.score_settled([asked])[0, 0] > 0.5)


def test_the_nearest_stands_for_a_side_that_has_no_neighbour():
    # Both of the nearest of all are full heaps; the cubes still tell them from the nearest other.
    model = learnt(Method(name="test", neighbors=(2,), of_all=True))
    asked = fallen(heap(148, 0))
    weights = model.neighbor_weights(model.distances([asked], RADIUS)[0], "cup")
    others = model.distances([asked], RADIUS)[0][~model.members_[:, 0]]
    means = [np.average(model.distances([asked], RADIUS)[0] ** 2, weights=weights), others.min() ** 2]
    assert not weights[~model.members_[:, 0]].any()
    assert cube_evidence(model, asked, "cup", RADIUS).speaks_for.sum() == pytest.approx(means[1] - means[0])


def test_cubes_are_where_their_spheres_are():
    model = learnt(Method(name="test"))
    centers = heap(200, 5)
    cubes = cube_evidence(model, fallen(centers), "cup", RADIUS)
    low, high = cubes.corners[:, None] - 1e-9, cubes.corners[:, None] + cubes.side + 1e-9
    within = ((centers >= low) & (centers <= high)).all(axis=2).sum(axis=1)
    assert (within >= cubes.counts).all() and within.sum() == pytest.approx(200, abs=12)  # on a border: in two cubes


def test_positions_travel_within_half_a_step():
    points = heap(1000, 1)
    data = quantised(points)
    steps = np.frombuffer(base64.b64decode(data["positions"]), "<u2").reshape(-1, 3)
    assert np.abs(np.array(data["start"]) + steps * data["step"] - points).max() <= 0.51 * data["step"] < 1e-5


def test_a_fine_mesh_is_thinned_and_keeps_its_shape():
    side = 260
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, side), np.linspace(-0.5, 0.5, side))
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    squares = [[corner, corner + 1, corner + side], [corner + 1, corner + side + 1, corner + side]]
    mesh = Mesh(
        np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), np.concatenate([np.transpose(s) for s in squares])
    )
    small = thinned(mesh)
    assert len(mesh.faces) > 100_000 >= len(small.faces) > 20_000
    assert np.abs(np.ptp(small.vertices, axis=0) - np.ptp(mesh.vertices, axis=0)).max() < 0.01  # a cell
    assert len(clustered(mesh, 10.0).faces) == 0


def test_nothing_settled_is_shown_too():
    data = shown(clouds.plate(), np.empty((0, 3)))
    assert data["spheres"][0]["positions"] == ""


def test_names_cannot_end_the_script():
    cloud = Cloud(clouds.mug().points, "</script><script>alert(1)</script>")
    html = display_html(shown(cloud, heap(10, 0)))
    assert html.count("</script>") == 1
    assert json.loads(re.search(r">(\{.*\})</script>", html)[1])["name"] == cloud.name


@pytest.mark.parametrize(("size", "expected"), [(0.1, 0.005), (0.8, 0.02), (2.5, 0.05)])
def test_the_radius_fits_the_object(size, expected):
    cloud = Cloud(np.linspace(0, [size, size / 2, 0.01], 20))
    assert fitting_radius(RADII, cloud.size, SPHERES_ACROSS) == expected


@pytest.fixture
def call(tmp_path, monkeypatch):
    """Return a function that runs the command in a folder of its own, where there is a mug."""
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.chdir(tmp_path)
    np.savetxt("mug.xyz", clouds.mug().points)

    def spherefunc(*arguments):
        done = CliRunner().invoke(application(), ["view", *map(str, arguments)])
        if isinstance(done.exception, InputError):  # what `main` turns into a line and a code
            return 2, "", str(done.exception)
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        return done.exit_code, done.stdout, done.stderr

    return spherefunc


def test_a_page_stands_alone(call, tmp_path):
    code, out, _ = call("mug.xyz", "--explain", "--radius", "1cm", "--json")
    assert code == 0 and json.loads(out) == ["mug.html"]
    page = (tmp_path / "mug.html").read_text()
    assert len(page) < 8e6
    assert not re.search(r"""(src|href)=["'](?!data:)|https?://|@import""", page)
    assert "settled" in page and "Why: cup" in page and "with walls on every side" in page
    assert "objects and copies that it learnt" in page and "change without it" in page
    assert not re.search(r">[+-]0\.00<", page)  # quantities that change nothing are left out


def test_a_broken_file_and_a_missing_backend_cost_only_themselves(call, tmp_path):
    (tmp_path / "broken.ply").write_text("nothing")
    code, out, err = call("broken.ply", "mug.xyz", "--backend", "fast,nosuch", "--radius", "1cm", "--json")
    assert code == 2 and json.loads(out) == ["mug.html"]
    assert [name in line for name, line in zip(("nosuch", "broken.ply"), err.splitlines(), strict=True)] == [True] * 2


def test_a_recording_needs_its_package_and_costs_no_page(call, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    code, out, err = call("mug.xyz", "--radius", "1cm", "--rerun", "mug.rrd", "--json")
    assert code == 2 and json.loads(out) == ["mug.html"]
    assert "spherefunc-bullet[rerun]" in err and not (tmp_path / "mug.rrd").exists()


def test_a_recording_of_drops_is_written(call, tmp_path):
    pytest.importorskip("rerun")
    code, _, err = call("mug.xyz", "--radius", "1cm", "--rerun", "mug.rrd")
    assert code == 0 and "mug.rrd" in err and (tmp_path / "mug.rrd").stat().st_size > 10_000


def test_spheres_of_a_recording_appear_at_the_drops_that_settled():
    result = make_simulator("fast").drop(clouds.mug(), DropSettings(radius=0.01), seed=0)
    numbers = settled_drops(result)
    assert len(numbers) == len(result.centers) and (np.diff(numbers) > 0).all()
    assert 1 <= numbers[0] and numbers[-1] <= result.drops
    unknown = replace(result, columns=np.empty((0, 2)), outcomes=np.empty(0, np.int8))
    assert settled_drops(unknown).tolist() == list(range(1, len(result.centers) + 1))


@pytest.mark.parametrize(
    "arguments", [("mug.xyz", "--out", "mug.txt"), ("mug.xyz", "--out", "no/such.html"), ("mug.xyz", "--backend", ",")]
)
def test_what_cannot_be_is_refused_at_once(call, tmp_path, arguments):
    code, _, err = call(*arguments)
    assert code == 2 and "expected" in err
    assert not list(tmp_path.glob("*.html"))


def test_objects_of_one_name_get_two_pages_or_share_one(call, tmp_path):
    (tmp_path / "other").mkdir()
    shutil.copy("mug.xyz", "other/mug.xyz")
    _, out, _ = call("mug.xyz", "other/mug.xyz", "--radius", "1cm", "--json")
    assert json.loads(out) == ["mug.html", "mug_2.html"]
    _, out, _ = call("mug.xyz", "other/mug.xyz", "--radius", "1cm", "--out", "both.html", "--json")
    assert json.loads(out) == ["both.html"]
    assert (tmp_path / "both.html").read_text().count('<div class="display">') == 2


@needs_browser
@pytest.mark.slow
def test_a_browser_draws_it_without_errors(tmp_path):
    centers = np.array([[0.0, 0.0, 0.03], [0.01, 0.015, 0.05], [-0.015, 0.0, 0.07]])
    counted = histogram_cubes(centers, 0.01)
    swayed = dict.fromkeys(("members", "others"), counted.counts) | {
        "speaks_for": np.linspace(-1, 1, len(counted.counts))
    }
    box = Mesh(np.array([[-0.04, -0.04, 0], [0.04, -0.04, 0], [0, 0.04, 0]], float), np.array([[0, 1, 2]]))
    parts = []
    for mesh, cubes in ((box, counted), (None, replace(counted, **swayed))):
        layer = Layer(radius=0.01, centers=centers, cubes=cubes, note="three")
        parts.append(display_html(display(Cloud(clouds.mug().points, "mug", mesh), [Panel(title="a", layers=[layer])])))
    page = tmp_path / "page.html"
    page.write_text(display_page("test", parts).replace("</body>", f"{CLICKS}</body>"))
    drawn = draw(page, tmp_path, shows_spheres, size=(400, 420))
    assert not drawn.console, drawn.console
    assert shows_spheres(drawn.pixels)


def shows_spheres(pixels: np.ndarray) -> bool:
    """Return whether pixels (H, W, 3) show spheres' strong colours; page, object and cubes are pale."""
    part = pixels[170:400]
    return (part.max(axis=-1) - part.min(axis=-1) > 60).mean() > 0.01


@pytest.mark.slow
def test_tables_and_a_still_stand_in_the_page_itself(tmp_path):
    page = viewed(tmp_path, "--explain")
    markup = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert "drops of spheres of radius" in markup and "change without it" in markup
    stills = re.findall(r'<img alt="[^"]*" src="data:image/png;base64,([^"]+)"', markup)
    assert len(stills) == 2  # the spheres, and what the answer is read from
    for still in stills:
        picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(still))).convert("RGB"), float)
        assert picture.std() > 5 and len(np.unique(picture.reshape(-1, 3), axis=0)) > 50  # neither blank nor grey alone


@pytest.mark.slow
def test_a_page_explains_by_the_drops_that_classify_reads(tmp_path):
    page = viewed(tmp_path, "--explain")
    for sentence in sf.classify(tmp_path / "mug.xyz").reasons:
        assert html.escape(sentence) in page


@pytest.mark.slow
@needs_browser
def test_a_browser_without_webgl_shows_tables_and_stills(tmp_path):
    (tmp_path / "page.html").write_text(viewed(tmp_path, "--explain"))
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-3d-apis"]
    shown = document(tmp_path / "page.html", tmp_path, lambda shown: "WebGL 2 is off" in shown, flags)
    assert "WebGL 2 is off" in shown and shown.count("data:image/png") == 2 and "change without it" in shown


@pytest.mark.slow
@needs_browser
def test_a_browser_that_draws_has_no_still_beside_it(tmp_path):
    (tmp_path / "page.html").write_text(viewed(tmp_path, "--explain"))
    shown = document(tmp_path / "page.html", tmp_path, lambda shown: shown and "data:image/png" not in shown)
    assert "<canvas" in shown and "data:image/png" not in shown


def viewed(tmp_path, *options: str) -> str:
    """Return the page of a small mug."""
    np.savetxt(tmp_path / "mug.xyz", clouds.mug().points)
    command = ["view", str(tmp_path / "mug.xyz"), "--backend", "fast", "--out", str(tmp_path / "out.html"), *options]
    done = CliRunner().invoke(application(), command)
    assert done.exit_code == 0, done.output
    return (tmp_path / "out.html").read_text()
