"""Sizes that `dataset describe` prints, and by which `dataset select` chooses."""

from __future__ import annotations

import json

import numpy as np
import pytest
from commands import spherefunc


@pytest.fixture
def scans(tmp_path):
    """A scan with points that the sensor did not measure, and one that has no others."""
    (tmp_path / "scans" / "cup").mkdir(parents=True)
    np.save(tmp_path / "scans" / "cup" / "mug.npy", [[0, 0, 0], [np.nan, 0, 0], [0.08, 0.08, 0.1]])
    np.save(tmp_path / "scans" / "cup" / "nothing.npy", np.full((3, 3), np.nan))
    return tmp_path / "scans"


def test_points_that_were_not_measured_do_not_count(scans):
    done = spherefunc("dataset", "describe", scans, "--json")
    assert json.loads(done.stdout)["height"] == {"cup": {"min": 0.1, "median": 0.1, "max": 0.1}}
    assert done.returncode == 2 and "nothing.npy: expected points, got none that are finite" in done.stderr


def test_scans_are_selected_by_the_points_that_were_measured(scans, tmp_path):
    done = spherefunc("dataset", "select", scans, tmp_path / "small", "--up-to", "50cm", "--json")
    assert json.loads(done.stdout)["objects"] == 1


def test_it_is_said_that_no_licence_permits_it(scans, tmp_path):
    done = spherefunc("dataset", "select", scans, tmp_path / "free", "--permissive")
    assert done.returncode == 2 and "expected objects with a licence such as CC-BY, got none among 2" in done.stderr


def test_it_is_said_that_nothing_can_be_copied(scans, tmp_path):
    (scans / "cup" / "mug.npy").unlink()
    done = spherefunc("dataset", "select", scans, tmp_path / "all")
    assert done.returncode == 2 and "expected objects that can be copied, got none among 1" in done.stderr
