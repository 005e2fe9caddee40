"""Pictures and pages of places, of objects and of rooms: what is found is drawn and written, where it is."""

from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import replace

import clouds
import numpy as np
import pytest
from browser import draw, needs_browser
from PIL import Image, ImageColor

from spherefunc_bullet.places.place import Place, Similarity
from spherefunc_bullet.places.words import place_columns
from spherefunc_bullet.scenes.recognition.room import Room
from spherefunc_bullet.scenes.report.files import room_page
from spherefunc_bullet.scenes.report.picture import room_picture
from spherefunc_bullet.scenes.scans.levelling import Levelling
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.segmentation import WALL
from spherefunc_bullet.viewer.place_pictures import COLOURS, places_picture, put_down, write_places_page

SQUARE = np.array([[-0.2, -0.2, 0.5], [0.2, -0.2, 0.5], [0.2, 0.2, 0.5], [-0.2, 0.2, 0.5]])
SHARED = {"position": np.array([0.0, 0.0, 0.5]), "region": (SQUARE,), "area": 0.16, "height": 0.5, "score": 0.9}
SEAT = Place(kind="sit", function="sittable", heading_deg=90.0, depth=0.4, back=True, **SHARED)
TOP = Place(kind="put", function="table", radius=0.2, **SHARED)
VESSEL = Place(kind="pour", function="cup", capacity_ml=310.4, filled_ml=280.0, spill_tilt_deg=41.0, **SHARED)
Y_UP = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # from z up
UPRIGHT = np.eye(4)
LYING = Similarity(Y_UP, 100.0, np.array([3.0, -2.0, 5.0]))


def floor_with_a_top(T_level_scan: np.ndarray = UPRIGHT) -> tuple[Scan, Room]:
    """Return the scan of a floor and a square top over it, in the frame of the scan."""
    flat = np.stack(np.meshgrid(*2 * [np.arange(-1.0, 1.0, 0.02)], [0.0]), axis=-1).reshape(-1, 3)
    points = np.vstack([flat, 0.2 * flat + [0, 0, 0.5]])
    levelling = Levelling(T_level_scan=T_level_scan, source="floor", floor_seen=True, noise=0.001)
    room = Room(levelling=levelling, labels=np.repeat(np.int32([-1, 0]), len(flat)), objects=[])
    return Scan(name="room", points=levelling.to_scan(points)), room


def uses_on(page: str) -> dict[str, np.ndarray]:
    """Return the middles (N, 3) of the spheres that show the places on the page of a room, by the name of the use."""
    uses = json.loads(re.search(r'<script type="application/json">(.*?)</script>', page)[1])["uses"]
    found = {}
    for use in uses:
        middles = use["middles"]
        steps = np.frombuffer(base64.b64decode(middles["positions"]), "<u2").reshape(-1, 3)
        found[use["name"]] = np.array(middles["start"]) + steps * middles["step"]
    return found


@pytest.mark.parametrize("rotation", [Y_UP, Y_UP.T, np.eye(3)], ids=["y up", "x up", "z up"])
def test_a_place_comes_back_from_the_frame_of_the_input(rotation):
    to_input = Similarity(rotation, 100.0, LYING.shift)
    seat = replace(SEAT, spill_heading_deg=350.0)
    there = seat.moved(to_input)
    back = there.moved_back(to_input)
    assert there.height == pytest.approx(50.0) and back.height == pytest.approx(0.5)
    assert back.heading_deg == pytest.approx(90.0) and back.spill_heading_deg == pytest.approx(350.0)
    assert np.allclose(back.position, seat.position) and np.allclose(back.region[0], SQUARE)


@pytest.mark.parametrize("place", [SEAT, TOP, VESSEL], ids=lambda place: place.kind)
def test_the_picture_of_a_room_shows_its_places(place):
    scan, room = floor_with_a_top()
    strongest = int(np.argmax(ImageColor.getrgb(COLOURS[place.kind])))
    drawn = [room_picture(scan, room, size=(400, 300), used=used) for used in (None, {None: [place]})]
    inked = [(np.asarray(each, int)[..., strongest] > 1.3 * np.asarray(each).min(axis=2)).sum() for each in drawn]
    assert inked[0] == 0 and inked[1] > 400  # the key, a square and words, has less


def test_the_page_of_a_room_shows_its_places_where_they_are():
    T_level_scan = np.eye(4)
    T_level_scan[:3, :3], T_level_scan[:3, 3] = Y_UP.T, [0.3, 0.2, 0.1]
    scan, room = floor_with_a_top(T_level_scan)
    to_scan = Similarity(Y_UP, 1.0, -Y_UP @ T_level_scan[:3, 3])
    page = room_page(scan, room, {4: [SEAT.moved(to_scan)], None: [VESSEL.moved(to_scan)]})
    shown = uses_on(page)
    assert set(shown) == {"a place to sit", "a place to pour"}
    person = shown["a place to sit"]
    assert person[:, 2].max() == pytest.approx(0.5 + 0.89, abs=0.05)
    feet = person[person[:, 2] < 0.15]
    assert feet[:, 1].min() > 0.3 and np.abs(feet[:, 0]).max() < 0.2  # ahead of a person who faces +y
    assert "<td>4</td><td>sit</td>" in page and "holds 310 ml, spills at 41°" in page
    partly = replace(SEAT, heading_deg=None, inferred=True, note="seen in part")
    page = room_page(scan, room, {4: [partly.moved(to_scan)]})
    unknown = uses_on(page)["a place to sit"]
    assert np.ptp(unknown[:, 2]) < 1e-4 and ">seen in part<" in page  # no person: the way to face is not known
    assert uses_on(room_page(scan, room)) == {} and "can be used" not in room_page(scan, room)


@needs_browser
@pytest.mark.slow
def test_a_browser_draws_the_places_of_a_room(tmp_path):
    page = tmp_path / "room.html"
    page.write_text(room_page(*floor_with_a_top(), {None: [SEAT]}))

    def shows_red(pixels: np.ndarray) -> bool:
        red = (pixels[..., 0] > 100) & (pixels[..., 0] > 2 * pixels[..., 1])
        return red.sum() > 1000

    drawn = draw(page, tmp_path, shows_red)
    assert not drawn.console, drawn.console
    assert shows_red(drawn.pixels)


@needs_browser
@pytest.mark.slow
def test_walls_before_the_room_do_not_hide_it_on_the_page(tmp_path):
    """Of four black walls around a green block, those on the side of the eye are left out."""
    across, up = (grid.ravel() for grid in np.meshgrid(np.arange(-1, 1, 0.01), np.arange(0, 3, 0.01)))
    side = np.ones_like(across)
    walls = [np.column_stack([*pair, up]) for one in (side, -side) for pair in ((across, one), (one, across))]
    block = np.random.default_rng(0).uniform(-0.4, 0.4, (60_000, 3)) + [0, 0, 0.4]
    points, count = np.vstack([block, *walls]), 4 * len(across)
    labels = np.append(np.zeros(len(block), np.int32), np.full(count, WALL, np.int32))
    colours = np.where((labels == WALL)[:, None], [0, 0, 0], [0, 255, 0]).astype(np.uint8)
    room = replace(floor_with_a_top()[1], labels=labels)
    (tmp_path / "room.html").write_text(room_page(Scan(name="room", points=points, colors=colours), room))

    def shows_green(pixels: np.ndarray) -> bool:
        return ((pixels[..., 1] > 200) & (pixels[..., 0] < 50)).sum() > 10_000

    drawn = draw(tmp_path / "room.html", tmp_path, shows_green)
    assert not drawn.console, drawn.console
    assert shows_green(drawn.pixels)


def test_the_page_of_an_object_says_what_the_console_says(tmp_path):
    """Capacity, spill and all poses, in the coordinates of the file; the person sits in the cloud's."""
    poses = tuple(np.array([[1.0, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]]) for x in np.arange(45) / 100)
    found = [place.moved(LYING) for place in (SEAT, replace(TOP, poses=poses), VESSEL)]
    write_places_page([(clouds.plate(), LYING, found)], tmp_path / "places.html", unit="cm")
    page = (tmp_path / "places.html").read_text()
    assert "lengths in cm; positions are those of the file" in page and "holds 310 ml, spills at 41°" in page
    for place in found:
        assert all(f">{cell}<" in page for cell in place_columns(place.as_json(), "cm")[1:])
    assert place_columns(replace(SEAT, heading_deg=359.7).as_json())[3] == "0°"
    assert "45 poses" in page and ">proof<" not in page


def test_the_legend_of_one_object_fits_its_picture():
    places = [SEAT, replace(TOP, poses=(np.eye(4),)), VESSEL]
    picture = Image.open(io.BytesIO(places_picture([("all of it", clouds.plate().points, places)])))
    key = np.asarray(picture.convert("L"))[-90:]
    assert (key < 200).sum() > 500 and (key[:, :4] > 250).all() and (key[:, -4:] > 250).all()


def test_every_pose_is_drawn_where_the_object_stands():
    """The origin of the object's file is 3 m aside; the best pose is at the place's position."""
    aside, poses = np.array([3.0, 0.0, 1.0]), []
    for x in np.arange(45) / 100:
        turn, pose = np.radians(300 * x), np.eye(4)
        pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        pose[:3, 3] = [x, 0.1, 0.5] - pose[:3, :3] @ aside
        poses.append(pose)
    stands = put_down(replace(TOP, position=np.array([0.0, 0.1, 0.5]), poses=tuple(poses)))
    assert np.allclose(stands, [[x, 0.1, 0.5] for x in np.arange(45) / 100])
    assert put_down(TOP).shape == (0, 3)
