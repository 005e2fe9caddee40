"""A ROS 2 node: finds what can be sat on, drunk from and put objects on in clouds, publishes boxes and places.

    pip install spherefunc-bullet            # into the environment that has ROS 2
    python3 functional_objects.py --ros-args -r cloud:=/camera/depth/points -p level_frame:=base_link

It answers the newest cloud and drops what comes meanwhile. Where /tf leads from the cloud's frame to ``level_frame``
the cloud is turned into that, whose z is taken as up; else gravity is found in the cloud itself.
"""

from __future__ import annotations

import sys

import numpy as np

import spherefunc_bullet as sf
from spherefunc_bullet.scenes.ros.boxes import boxes_of, fill_arrow, fill_marker
from spherefunc_bullet.scenes.ros.frames import matrix_of
from spherefunc_bullet.scenes.ros.point_cloud2 import PointCloud2, points_of

WAIT = 0.2  # seconds for the transform of a cloud, which often comes later than the cloud
DELETE_ALL = 3  # of visualization_msgs/Marker: what was drawn before


def level_points(cloud: PointCloud2, transform: object | None) -> tuple[np.ndarray, str]:
    """Return a cloud's points (N, 3), in the level frame where a transform leads there, and which way is up."""
    points = points_of(cloud)
    if transform is None:
        return points, "auto"
    T_level_cloud = matrix_of(transform)
    return points @ T_level_cloud[:3, :3].T + T_level_cloud[:3, 3], "z"


def markers_of(points: np.ndarray, up: str, header: object, new_marker: type) -> list:
    """Return markers of what is found in points (N, 3): first one that clears those of the cloud before."""
    cleared = new_marker()
    cleared.header, cleared.action = header, DELETE_ALL
    objects = sf.find_objects(points, units="m", up=up, inferred=True)
    boxes = boxes_of([item for item in objects if not item.inferred])
    markers = [fill_marker(new_marker(), box, number) for number, box in enumerate(boxes)]
    places = [place for item in objects for place in item.places]
    markers += [fill_arrow(new_marker(), place, number) for number, place in enumerate(places)]
    for marker in markers:
        marker.header = header
    return [cleared, *markers]


def main():
    """Run the node until it is stopped."""
    try:
        import rclpy
    except ImportError:
        sys.exit("functional_objects.py: expected the Python of a ROS 2 installation, found no rclpy in this one")
    from rclpy.duration import Duration
    from rclpy.executors import MultiThreadedExecutor
    from rclpy.node import Node
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import PointCloud2 as Cloud
    from tf2_ros import Buffer, TransformException, TransformListener
    from visualization_msgs.msg import Marker, MarkerArray

    class FunctionalObjects(Node):
        def __init__(self):
            super().__init__("functional_objects")
            self.level_frame = self.declare_parameter("level_frame", "").value
            self.frames = Buffer()
            self.listener = TransformListener(self.frames, self)
            self.publisher = self.create_publisher(MarkerArray, "functional_objects", 1)
            newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
            self.create_subscription(Cloud, "cloud", self.answer, newest)

        def transform_of(self, header):
            if not self.level_frame:
                return None
            asked = self.level_frame, header.frame_id, header.stamp
            try:
                return self.frames.lookup_transform(*asked, timeout=Duration(seconds=WAIT)).transform
            except TransformException as error:
                self.get_logger().warning(f"no way to {self.level_frame}, so gravity is looked for: {error}")
                return None

        def answer(self, cloud):
            transform = self.transform_of(cloud.header)
            try:
                points, up = level_points(cloud, transform)
                if transform is not None:
                    cloud.header.frame_id = self.level_frame
                markers = markers_of(points, up, cloud.header, Marker)
            except sf.InputError as error:
                self.get_logger().warning(str(error))
                return
            self.publisher.publish(MarkerArray(markers=markers))

    rclpy.init()
    rclpy.spin(FunctionalObjects(), MultiThreadedExecutor())  # hears transforms while it waits for one


if __name__ == "__main__":
    main()
