"""What a scan holds of each object, cut out by the truth and completed as recognition completes what it cuts out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from spherefunc_bullet.clouds.cloud import Cloud

from ..recognition.completion import DEFAULT
from ..recognition.judging import object_cloud
from .scans import VirtualScan


def partial_views(scan: VirtualScan, completion: Sequence[str] = DEFAULT) -> Iterator[tuple[int, Cloud]]:
    """Yield the number and the cloud of every object that the scan shows enough of.

    They are perfectly segmented: what is still wrong about their functions is not the segmentation's fault. As
    training examples they are as one-sided as what recognition meets.

    Parameters
    ----------
    completion : sequence of str
        See `completion.complete`.
    """
    for number in scan.seen().tolist():
        placed = scan.room.objects[number]
        height = float(placed.T_room_object[2, 3])
        points = scan.points[scan.labels == number]
        yield number, object_cloud(points, completion, height)[0]
