"""What the JSON of a room says of its frame is exact, also far from the origin."""

from __future__ import annotations

import numpy as np
import pytest
from room_shapes import room
from scipy.spatial.transform import Rotation

from spherefunc_bullet.scenes.recognition.room import Room
from spherefunc_bullet.scenes.report.files import room_json
from spherefunc_bullet.scenes.scans.levelling import level
from spherefunc_bullet.scenes.scans.scan import Scan


@pytest.mark.parametrize("offset", [[0, 0, 0], [500_000, 5_400_000, 300]])  # of UTM
def test_level_heights_follow_from_the_json(offset):
    points, truth = room()
    points = Rotation.from_rotvec([0.01, 0.02, 0.0]).apply(points) + offset
    levelling = level(points)
    labels = np.full(len(points), -3, np.int32)
    about = room_json(Scan(name="room", points=points), Room(levelling=levelling, labels=labels, objects=[]))
    T, floor = np.array(about["T_level_scan"]), about["floor"]
    assert np.allclose(points @ T[:3, :3].T + T[:3, 3], levelling.to_level(points), atol=1e-4)
    # The floor's height is given to a tenth of a millimetre.
    heights = points @ floor["normal"] - floor["height"]
    assert np.allclose(heights, levelling.to_level(points)[:, 2], atol=2e-4)
    assert np.abs(heights[truth == -1]).max() < 0.01
