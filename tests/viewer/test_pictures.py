"""Pictures: what is drawn where, by geometry."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from PIL import Image

from spherefunc_bullet.scenes.recognition.recognition import Room
from spherefunc_bullet.scenes.report.picture import BoxMark, draw_marks, in_front, look_at, room_picture, span, splatted
from spherefunc_bullet.scenes.scans.levelling import Levelling
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.segmentation import WALL
from spherefunc_bullet.viewer.colours import sphere_colours
from spherefunc_bullet.viewer.mechanics_pictures import captioned, in_rows
from spherefunc_bullet.viewer.pictures import (
    CUT_COLOUR,
    OBJECT_COLOUR,
    CameraView,
    camera_rays,
    drawn_box,
    render,
)

FROM_ABOVE = CameraView(azimuth_deg=-90.0, elevation_deg=89.0, size=(120, 100), supersample=1)


def plate() -> trimesh.Trimesh:
    box = trimesh.creation.box((0.4, 0.3, 0.02))
    box.apply_translation((0, 0, 0.01))
    return box


def open_box() -> trimesh.Trimesh:
    """A closed shell with walls 2 cm thick around a hollow that is open above."""
    walls = [
        trimesh.creation.box(bounds=bounds)
        for bounds in (
            [(-0.2, -0.2, 0.0), (0.2, 0.2, 0.02)],
            # Parts overlap and share no corner: a corner of two closed boxes makes an edge of four faces.
            [(-0.2, -0.19, 0.01), (-0.18, 0.19, 0.3)],
            [(0.18, -0.19, 0.01), (0.2, 0.19, 0.3)],
            [(-0.19, -0.2, 0.01), (0.19, -0.18, 0.29)],
            [(-0.19, 0.18, 0.01), (0.19, 0.2, 0.29)],
        )
    ]
    return trimesh.util.concatenate(walls)


def coloured(image) -> np.ndarray:
    """Return which pixels (H, W) have the strong colour of spheres; object, ground and cut are pale or brown."""
    red, green, blue = np.moveaxis(np.asarray(image, float), -1, 0)
    return np.maximum(green, blue) > 1.25 * red


def pixel(point, view: CameraView, low, high) -> tuple[int, int]:
    """Return row and column of the ray that passes nearest to a point."""
    rays = camera_rays(view, low, high)
    origins, directions = rays.origins, rays.directions
    offsets = point - origins
    along = (offsets * directions).sum(-1, keepdims=True)
    return np.unravel_index(np.argmin(np.linalg.norm(offsets - along * directions, axis=-1)), origins.shape[:2])


@pytest.mark.parametrize("at", [(-0.1, 0.05), (0.12, -0.08)])
def test_a_sphere_on_a_plate_is_where_its_centre_projects(at):
    center, radius = np.array([[*at, 0.05]]), 0.03
    image = render(plate().vertices, plate().faces, center, radius, FROM_ABOVE)
    seen = np.argwhere(dark_blue(image))
    expected = pixel(center[0], FROM_ABOVE, *drawn_box(plate().vertices, center, radius))
    # A disc's pixels are centred on its centre up to half a pixel, shading at the rim costs another.
    assert np.abs(seen.mean(axis=0) - expected).max() < 1.5


def test_a_sphere_covers_its_disc():
    center, radius = np.array([[0.0, 0.0, 0.05]]), 0.03
    low, high = drawn_box(plate().vertices, center, radius)
    origins = camera_rays(FROM_ABOVE, low, high).origins
    side = np.linalg.norm(origins[0, 1] - origins[0, 0])
    covered = dark_blue(render(plate().vertices, plate().faces, center, radius, FROM_ABOVE)).sum() * side**2
    assert covered == pytest.approx(np.pi * radius**2, rel=0.08)  # about 200 pixels, of which 40 lie on the rim


def dark_blue(image) -> np.ndarray:
    """Return where the lowest sphere's colour is: bluer than green, which greys are not."""
    red, green, blue = np.moveaxis(np.asarray(image, float), -1, 0)
    return blue > 1.5 * green + 5


def test_a_cut_shows_what_is_inside_and_the_walls_material():
    mesh, centers = open_box(), np.array([[0.0, 0.1, 0.05], [0.1, 0.1, 0.05], [0.0, 0.1, 0.15]])
    level = CameraView(azimuth_deg=-90.0, elevation_deg=5.0, size=(120, 100), supersample=1)
    cut = CameraView(azimuth_deg=-90.0, elevation_deg=5.0, size=(120, 100), supersample=1, cut=True)
    closed, opened = (render(mesh.vertices, mesh.faces, centers, 0.03, view) for view in (level, cut))
    assert not coloured(closed).any()  # the walls are twice as high as the spheres
    assert coloured(opened).sum() > 50
    brown = np.asarray(opened, float) / np.array(CUT_COLOUR) / 255
    shades = brown.std(axis=-1) < 0.03  # proportional to the cut's colour, whatever the light
    assert shades.sum() > 100


def test_a_cut_takes_whole_spheres_away():
    front = np.array([[0.0, -0.1, 0.05]])
    cut = CameraView(azimuth_deg=-90.0, elevation_deg=5.0, size=(120, 100), supersample=1, cut=True)
    mesh = open_box()
    assert not coloured(render(mesh.vertices, mesh.faces, front, 0.03, cut)).any()


@pytest.mark.parametrize("faces", [None, np.empty((0, 3), int)])
@pytest.mark.slow
def test_a_cloud_without_faces_is_drawn(faces):
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 60), np.linspace(-0.2, 0.2, 60))
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.1)])
    image = np.asarray(render(points, faces, np.empty((0, 3)), 0.01, FROM_ABOVE), float) / 255
    middle = image[40:60, 50:70].reshape(-1, 3)
    tint = middle / middle.mean(axis=1, keepdims=True)
    assert np.allclose(tint, OBJECT_COLOUR / OBJECT_COLOUR.mean(), atol=0.02)  # of 256 steps, about four


def test_a_flat_layer_has_nearly_one_colour():
    flat, heap = np.array([0.100, 0.101]), np.array([0.1, 0.5])
    assert np.ptp(sphere_colours(flat, 0.1), axis=0).max() < 0.05
    assert np.ptp(sphere_colours(heap, 0.1), axis=0).max() > 0.5


def test_captions_and_tiles_have_the_size_asked_for():
    image = render(plate().vertices, plate().faces, np.empty((0, 3)), 0.01, FROM_ABOVE)
    framed = captioned(image, "Plate", "no spheres")
    assert framed.width == 120 and framed.height > 100
    assert in_rows([framed] * 4, columns=3).size == (360, 2 * framed.height)


def test_the_texts_of_boxes_at_one_place_stand_above_each_other():
    corners = np.array(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], indexing="ij")).reshape(3, 8).T
    camera = look_at(np.array([-1.0, -1, -1]), np.array([2.0, 2, 2]), 30.0, (800, 600))
    red, green, blue = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    inked = {}
    for number, colours in enumerate(((red,), (red, green, blue))):
        image = Image.new("RGB", camera.size, (252, 252, 252))
        # The first box alone tells how much ink its text has; a box of no size has no lines that could hide it.
        draw_marks(
            image, camera, [BoxMark(corners=corners[:1].repeat(8, axis=0), colour=c, text="cup") for c in colours]
        )
        inked[number] = (np.asarray(image) == red).all(axis=2).sum()
    assert inked[1] >= 0.7 * inked[0] > 0


@pytest.mark.parametrize("azimuth_deg", [0, 45, 90, 200])
def test_a_picture_shows_whole_boxes_where_the_scan_has_points_of_a_part_alone(azimuth_deg):
    """A table's box stands on the floor, also where a camera saw the top alone."""
    top = np.random.default_rng(0).uniform([-0.7, -0.4, 0.74], [0.7, 0.4, 0.76], (2000, 3))
    legs = np.array(np.meshgrid([-0.7, 0.7], [-0.4, 0.4], [0.0, 0.75], indexing="ij")).reshape(3, 8).T
    camera = look_at(*span(top, [legs]), azimuth_deg, (800, 600))
    pixels = camera.project(legs)[:, :2]
    assert ((pixels >= 0) & (pixels <= camera.size)).all()
    alone = look_at(*span(top, []), azimuth_deg, (800, 600)).project(legs)[:, :2]
    assert not ((alone >= 0) & (alone <= camera.size)).all()


def upright_sheet(y: float) -> np.ndarray:
    """Return points (N, 3) a centimetre apart on a sheet of 1 x 1 m."""
    x, z = np.meshgrid(np.arange(-0.5, 0.5, 0.01), np.arange(0.0, 1.0, 0.01))
    return np.column_stack([x.ravel(), np.full(x.size, y), z.ravel()])


def test_points_of_a_surface_close_its_gaps_and_hide_what_is_behind():
    near, far = upright_sheet(-0.5), upright_sheet(0.5)
    red, green = np.tile(np.uint8([255, 0, 0]), (len(near), 1)), np.tile(np.uint8([0, 255, 0]), (len(far), 1))
    camera = look_at(np.array([-0.5, -0.5, 0.0]), np.array([0.5, 0.5, 1.0]), -90.0, (800, 600))
    image = splatted(camera, np.vstack([near, far]), np.vstack([red, green]), np.full(2 * len(near), 0.015))
    x, y = camera.project(np.array([[-0.3, -0.5, 0.9], [0.3, -0.5, 0.1]]))[:, :2].round().astype(int).T
    assert (image[y[0] : y[1], x[0] : x[1]] == [255, 0, 0]).all()  # though a point is some four pixels from the next


def test_a_picture_is_filled_by_what_it_shows():
    points = np.random.default_rng(0).uniform([-2, -0.2, 0], [-1, 0.2, 0.1], (500, 3))
    camera = look_at(np.array([-3.0, -3, 0]), np.array([3.0, 3, 2]), 45.0, (800, 600)).filled_by(points)
    low, high = camera.project(points)[:, :2].min(axis=0), camera.project(points)[:, :2].max(axis=0)
    assert (low + high) / 2 == pytest.approx([400, 300], abs=1)
    assert ((high - low) / camera.size).max() == pytest.approx(0.92, abs=0.01)


def test_walls_between_the_camera_and_the_room_are_left_out():
    points = np.vstack([upright_sheet(-1.0), upright_sheet(1.0), upright_sheet(0.0)])
    is_wall = np.repeat([True, True, False], len(points) // 3)
    camera = look_at(np.array([-0.5, -1.0, 0.0]), np.array([0.5, 1.0, 1.0]), -90.0, (80, 60))
    assert np.array_equal(np.unique(points[in_front(camera, points, is_wall), 1]), [-1.0])


def test_a_scan_of_nothing_but_a_wall_is_shown():
    levelling = Levelling(T_level_scan=np.eye(4), source="assumed", floor_seen=False, noise=None)
    points = upright_sheet(0.0)
    room = Room(levelling=levelling, labels=np.full(len(points), WALL, np.int32), objects=[])
    image = np.asarray(room_picture(Scan(name="wall", points=points), room, size=(160, 120)))
    assert (image < 240).all(axis=2).any()
