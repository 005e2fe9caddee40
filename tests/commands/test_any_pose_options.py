"""Options and remarks that have no meaning where every pose is tried."""

from __future__ import annotations

import pytest
import trimesh
from commands import spherefunc

from spherefunc_bullet.commands.options import run_on_files
from spherefunc_bullet.console import Failures
from spherefunc_bullet.simulator import make_simulator


@pytest.mark.parametrize("command", [["poses", "--backend", "fast"], ["classify", "--any-pose"]])
def test_the_axis_of_a_gltf_is_not_doubted(tmp_path, command):
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "box.glb")
    done = spherefunc(*command, tmp_path / "box.glb")
    assert done.returncode == 0 and "up" not in done.stderr


def test_an_axis_beside_all_poses_is_refused(tmp_path):
    done = spherefunc("classify", tmp_path / "box.glb", "--any-pose", "--up", "y")
    assert done.returncode == 2 and "--up y: expected without --any-pose, which tries every pose" in done.stderr


def test_several_processes_try_poses(tmp_path, monkeypatch):
    """Their results come in the order in which they are ready, and are printed in the order of the files."""
    asked = []

    def run_tasks(function, tasks, files, **how):
        asked.append(how["jobs"])
        return reversed([(number, (None, number)) for number in range(len(tasks))])

    monkeypatch.setattr("spherefunc_bullet.processes.tasks.run_tasks", run_tasks)
    files = [tmp_path / "a.ply", tmp_path / "b.ply"]
    found = run_on_files(None, files, make_simulator("fast"), (), "classifying", Failures(), jobs=2)
    assert found == [(files[0], (None, 0)), (files[1], (None, 1))] and asked == [2]
