"""``spherefunc demo --live``: an object of the catalogue, spheres that fall on it, and its functions, in a browser.

Each change of a slider drops the spheres again; the bars show the scores by the model of the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from threading import Event
from typing import TYPE_CHECKING

import numpy as np
import trimesh

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.console import say
from spherefunc_bullet.datasets.catalogue import make_catalogue
from spherefunc_bullet.errors import explaining
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.settling.drops import RunLimit
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.viewer.colours import sphere_colours

from ..machine import usable_backends

if TYPE_CHECKING:
    from viser import ViserServer

CATALOGUE, SEED = "household", 7  # a seed that no model has learnt
FIRST = "mug_02"
COLOURS = {"cup": (255, 140, 0), "sittable": (0, 170, 190), "table": (200, 0, 170)}  # the same in pictures of scans
OBJECT_COLOUR = (190, 180, 165)
FRAMES, AT_ONCE = 40, 0.15  # of a fall; share of the spheres in the air at once
PAUSE = 0.04  # seconds between two frames


@dataclass(frozen=True, kw_only=True)
class LiveResult:
    """The result of one change of the controls."""

    cloud: Cloud
    starts: np.ndarray  # (S, 3) float, metres: where the settled spheres were dropped
    rests: np.ndarray  # (S, 3) float, metres
    drops: int  # all drops, whether they settled or not
    answer: sf.Answer

    def at(self, share: float) -> np.ndarray:
        """Return the positions (S, 3) of the spheres, metres, after a share 0..1 of the time."""
        begin = np.linspace(0, 1 - AT_ONCE, len(self.rests))
        fallen = np.clip((share - begin) / AT_ONCE, 0, 1)[:, None] ** 2
        return self.starts + fallen * (self.rests - self.starts)


def dropped(mesh: trimesh.Trimesh, name: str, *, radius: float, tilt: float, drops: int, backend: str) -> LiveResult:
    """Return the drops on a tilted object, and its answer.

    Parameters
    ----------
    radius : float
        Of the spheres, metres. The model of the package uses its own radii and numbers of drops.
    tilt : float
        Degrees about x, from how the object is used.
    drops : int
        Spheres dropped.
    """
    turn = trimesh.transformations.rotation_matrix(np.radians(tilt), [1, 0, 0])
    cloud = cloud_from_mesh(trimesh.transform_points(mesh.vertices, turn), mesh.faces, name)
    made = settle(cloud, backend, [radius], 0, RunLimit(drops=drops)).get(radius, ())
    rests = made.rests if made else np.empty((0, 3))
    starts = np.column_stack([rests[:, :2], np.full(len(rests), cloud.size[2] + 8 * radius)])
    if made and len(made.places) == len(made):
        starts[:, :2] = made.places[made.settled]
    answer = sf.classify(cloud, backend=backend)
    return LiveResult(cloud=cloud, starts=starts, rests=rests, drops=len(made), answer=answer)


class LiveDemo:
    """A page with controls, an object, its spheres and the scores of its functions."""

    def __init__(self, server: ViserServer, backends: tuple[str, ...]):
        self.server, self.changed = server, Event()
        self.meshes = {item.name: item.mesh for item in make_catalogue(CATALOGUE, seed=SEED)}
        gui = server.gui
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        self.object = gui.add_dropdown("Object", sorted(self.meshes), initial_value=FIRST)
        self.backend = gui.add_button_group("Simulator", backends)
        self.radius = gui.add_slider("Radius, mm", 5, 50, 1, 8)
        self.tilt = gui.add_slider("Tilt, degrees", 0, 180, 5, 0)
        self.drops = gui.add_slider("Drops", 10, 1000, 10, 200)
        self.text = gui.add_markdown("")
        with gui.add_folder("What is it for?"):
            self.bars = {}
            for name, colour in COLOURS.items():
                self.bars[name] = gui.add_markdown(name), gui.add_progress_bar(0.0, color=colour)
            self.reasons = gui.add_markdown("")
        server.scene.set_up_direction("+z")
        for control in (self.object, self.radius, self.tilt, self.drops):
            control.on_update(lambda _: self.changed.set())  # the simulation runs in the main thread
        self.backend.on_click(lambda _: self.changed.set())

    def update(self, pause: float = PAUSE) -> LiveResult:
        """Drop spheres with the current controls, show and return the result; moving a control ends the fall."""
        self.changed.clear()
        name, radius = self.object.value, self.radius.value / 1000
        how = {"radius": radius, "tilt": self.tilt.value, "drops": self.drops.value, "backend": self.backend.value}
        found = dropped(self.meshes[name], name, **how)
        self.show_answer(found, radius)
        self.show_fall(found, radius, pause)
        return found

    def show_answer(self, found: LiveResult, radius: float):
        """Show the number of settled spheres, the scores as bars, and the reasons."""
        settled = f"**{len(found.rests)}** of {found.drops} spheres of {format_length(radius)} settled"
        self.text.content = f"{settled} ({self.backend.value})."
        for name, (title, bar) in self.bars.items():
            score = found.answer.scores[name]
            title.content = f"**{name}** {score:.2f}" if name in found.answer.functions else f"{name} {score:.2f}"
            bar.value = 100 * score
        unsure = "**Unsure.** " if found.answer.unsure else ""
        self.reasons.content = unsure + "\n\n".join(found.answer.reasons)

    def show_fall(self, found: LiveResult, radius: float, pause: float):
        """Draw the object, and let the spheres fall one after another."""
        scene, mesh = self.server.scene, found.cloud.mesh
        style = {"color": OBJECT_COLOUR, "flat_shading": True, "side": "double"}
        scene.add_mesh_simple("/object", mesh.vertices, mesh.faces, **style)
        scene.add_grid("/ground", cell_size=0.1, section_size=1.0)
        self.look_at(found.cloud)
        if not len(found.rests):
            scene.remove_by_name("/spheres")
            return
        ball = trimesh.creation.icosphere(subdivisions=2, radius=radius)
        spheres = scene.add_batched_meshes_simple(
            "/spheres",
            ball.vertices,
            ball.faces,
            batched_wxyzs=np.tile([1.0, 0, 0, 0], (len(found.rests), 1)),
            batched_positions=found.at(0.0),
            batched_colors=(255 * sphere_colours(found.rests[:, 2], 12 * radius)).astype(np.uint8),
        )
        for share in np.linspace(0, 1, FRAMES):
            if self.changed.wait(pause):
                break
            spheres.batched_positions = found.at(share)

    def look_at(self, cloud: Cloud):
        """Turn all cameras to an object, seen from the front, slightly from above."""
        middle, far = np.array([0, 0, cloud.size[2] / 2]), 2.0 * float(np.linalg.norm(cloud.size))
        camera = self.server.initial_camera
        camera.position, camera.look_at = middle + far * np.array([0.45, -0.7, 0.5]), middle
        for client in self.server.get_clients().values():
            client.camera.position, client.camera.look_at = camera.position, camera.look_at


def start(port: int = 8080) -> LiveDemo:
    """Start the server and return its page, with the backends that are installed.

    Raises
    ------
    InputError
        If the package viser is missing.
    """
    with explaining("--live: expected the package viser; pip install 'spherefunc-bullet[viser]'", ImportError):
        import viser
    return LiveDemo(viser.ViserServer(host="127.0.0.1", port=port, verbose=False), usable_backends(("fast", "bullet")))


def serve(port: int):
    """Serve the page until it is stopped."""
    page = start(port)
    port = page.server.get_port()  # the next one if that was in use
    say(f"open http://localhost:{port}; over SSH, first: ssh -L {port}:localhost:{port} HOST")
    page.changed.set()
    while page.changed.wait():
        page.update()
