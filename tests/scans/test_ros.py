"""Bags of ROS 1 and 2: their clouds as scans, turned by /tf where it leads to a level frame, and boxes for a node."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from checkout import ROOT
from room_shapes import as_camera_sees, in_view, room
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.places.place import Place, Similarity
from spherefunc_bullet.scenes.recognition.objects import FoundObject
from spherefunc_bullet.scenes.ros.bag import is_bag, load_bag
from spherefunc_bullet.scenes.ros.boxes import boxes_of, fill_arrow, fill_marker
from spherefunc_bullet.scenes.ros.frames import FrameTree
from spherefunc_bullet.scenes.ros.point_cloud2 import colours_of, points_of
from spherefunc_bullet.scenes.segmentation.clusters import Box

rosbags = pytest.importorskip("rosbags", reason="the extra `ros` is not installed")
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402

NODE = ROOT / "examples" / "ros_node" / "functional_objects.py"
CLOUD, TF, IMAGE = "sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/CompressedImage"
CAMERA = "camera_depth_optical_frame"
KINDS = ("ros1", "sqlite3", "mcap")
BEGIN = 100  # seconds, of a bag's clock


class Messages:
    """Messages of one of ROS's versions, as recorded."""

    def __init__(self, ros1: bool):
        self.ros1 = ros1
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        if TF not in self.store.types:  # bags carry the definitions of what they hold; this one ROS 1's store lacks
            self.store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))

    def make(self, kind: str, /, **values):
        return self.store.types[kind](**values)

    def header(self, frame: str, time: float):
        stamp = self.make("builtin_interfaces/msg/Time", sec=int(time), nanosec=round(time % 1 * 1e9))
        return self.make("std_msgs/msg/Header", frame_id=frame, stamp=stamp, **({"seq": 0} if self.ros1 else {}))

    def cloud(self, points: np.ndarray, frame: str = CAMERA, time: float = BEGIN, **changes):
        """Return a cloud as drivers send it: x, y, z, four bytes of nothing, rgb; each row padded by 12 bytes."""
        width, step = len(points) // 2, 20
        records = np.zeros((2, width * step + 12), np.uint8)
        own = np.zeros(2 * width, {"names": list("xyz") + ["rgb"], "formats": ["<f4"] * 3 + ["<u4"],
                                   "offsets": [0, 4, 8, 16], "itemsize": step})  # fmt: skip
        own["x"], own["y"], own["z"] = points[: 2 * width].T
        own["rgb"] = 0x00FF8000
        records[:, : width * step] = own.view(np.uint8).reshape(2, -1)
        fields = [
            self.make("sensor_msgs/msg/PointField", name=name, offset=offset, datatype=7, count=1)
            for name, offset in (("x", 0), ("y", 4), ("z", 8), ("rgb", 16))
        ]
        values = {"header": self.header(frame, time), "height": 2, "width": width, "fields": fields}
        values |= {"is_bigendian": False, "point_step": step, "row_step": width * step + 12}
        return self.make(CLOUD, **(values | {"data": records.ravel(), "is_dense": False} | changes))

    def transform(self, parent: str, child: str, T: np.ndarray, time: float = BEGIN):
        """Return a message that says where a frame lies in its parent (4, 4)."""
        x, y, z, w = Rotation.from_matrix(T[:3, :3]).as_quat()
        turn = self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)
        shift = self.make("geometry_msgs/msg/Vector3", **dict(zip("xyz", T[:3, 3].tolist(), strict=True)))
        transform = self.make("geometry_msgs/msg/Transform", translation=shift, rotation=turn)
        stamped = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(parent, time),
            child_frame_id=child,
            transform=transform,
        )
        return self.make(TF, transforms=[stamped])

    def image(self):
        """Return a message of another type."""
        return self.make(IMAGE, header=self.header(CAMERA, BEGIN), format="png", data=np.zeros(4, np.uint8))


def write_bag(path: Path, kind: str, recorded: list[tuple[str, str, float, object]]) -> Path:
    """Write topic, type, seconds and message of each to a bag of one kind; return its path."""
    messages = Messages(kind == "ros1")
    path = path.with_suffix(".bag") if kind == "ros1" else path
    plugin = {"sqlite3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}
    with Writer1(path) if kind == "ros1" else Writer2(path, version=9, storage_plugin=plugin[kind]) as writer:
        known = {}
        for topic, name, time, make in recorded:
            if topic not in known:
                known[topic] = writer.add_connection(topic, name, typestore=messages.store)
            serialize = messages.store.serialize_ros1 if kind == "ros1" else messages.store.serialize_cdr
            writer.write(known[topic], round(time * 1e9), serialize(make(messages), name))
    return path


@pytest.fixture(scope="module")
def seen() -> np.ndarray:
    """Return what a camera that looks down sees of the room whose objects are known, (N, 3) in its frame."""
    return in_view(as_camera_sees(room()[0][::2]))


def T_level_camera() -> np.ndarray:
    """Return how the camera of `as_camera_sees` lies in a level frame, (4, 4)."""
    ends = np.vstack([np.zeros(3), np.eye(3)])
    seen = as_camera_sees(ends)
    T = np.eye(4)
    T[:3, :3] = seen[1:] - seen[0]  # row k: the level axis k in the camera's frame
    T[:3, 3] = -T[:3, :3] @ seen[0]
    return T


def recorded_room(seen: np.ndarray) -> list:
    return [
        ("/camera/points", CLOUD, BEGIN, lambda m: m.cloud(seen)),
        ("/tf_static", TF, BEGIN, lambda m: m.transform("base_link", CAMERA, T_level_camera())),
        ("/tf", TF, BEGIN, lambda m: m.transform("odom", "base_link", np.eye(4))),
        ("/image", IMAGE, BEGIN, lambda m: m.image()),
    ]


@pytest.fixture(scope="module", params=KINDS)
def bag(request, tmp_path_factory, seen):
    return write_bag(tmp_path_factory.mktemp("bags") / "room", request.param, recorded_room(seen))


def test_a_cloud_is_read_and_turned_level(bag, seen):
    said = []
    scan = load_bag(bag, report=said.append)
    wanted = seen[: len(seen) // 2 * 2] @ T_level_camera()[:3, :3].T + T_level_camera()[:3, 3]
    assert is_bag(bag) and scan.level_frame == "odom"
    assert np.allclose(scan.points, wanted, atol=1e-5)  # 32 bits in the message
    assert (scan.colors == [255, 128, 0]).all()
    assert "/camera/points at 100.000 s" in said[0] and "odom" in said[0]


def test_a_cloud_without_a_stamp_is_where_it_was_recorded(tmp_path, seen):
    """Time 0 is nearest to the first transform of the bag, wherever the robot has gone since."""
    moved = np.eye(4)
    moved[0, 3] = 3.0
    recorded = [
        ("/tf", TF, BEGIN - 9, lambda m: m.transform("odom", CAMERA, T_level_camera(), BEGIN - 9)),
        ("/tf", TF, BEGIN, lambda m: m.transform("odom", CAMERA, moved @ T_level_camera())),
        ("/camera/points", CLOUD, BEGIN, lambda m: m.cloud(seen, time=0)),
    ]
    wanted = seen[: len(seen) // 2 * 2] @ T_level_camera()[:3, :3].T + T_level_camera()[:3, 3] + [3, 0, 0]
    assert np.allclose(load_bag(write_bag(tmp_path / "bare", "mcap", recorded)).points, wanted, atol=1e-4)


@pytest.mark.parametrize("late", [0.05, 5.0])
def test_a_transform_of_another_time_is_reported(tmp_path, seen, late):
    recorded = [
        ("/camera/points", CLOUD, BEGIN, lambda m: m.cloud(seen)),
        ("/tf", TF, BEGIN, lambda m: m.transform("odom", CAMERA, T_level_camera(), BEGIN + late)),
    ]
    said = []
    load_bag(write_bag(tmp_path / "late", "mcap", recorded), report=said.append)
    assert ("odom, by a transform 5 s away" in said[0]) == (late == 5.0)


def test_without_frames_a_cloud_stays_as_the_sensor_saw_it(tmp_path, seen):
    path = write_bag(tmp_path / "bare", "mcap", recorded_room(seen)[:1])
    scan = load_bag(path)
    assert scan.level_frame is None and np.allclose(scan.points, seen[: len(scan)], atol=1e-5)


def test_a_single_file_of_a_bag_is_read(tmp_path, seen):
    path = write_bag(tmp_path / "room", "mcap", recorded_room(seen))
    (file,) = path.glob("*.mcap")
    assert np.array_equal(load_bag(file).points, load_bag(path).points)


@pytest.mark.parametrize("kind", ["ros1", "mcap"])
def test_the_first_cloud_from_a_time_on_is_taken(tmp_path, kind):
    clouds = [np.full((400, 3), k) + np.random.default_rng(0).random((400, 3)) for k in range(3)]
    recorded = [("/points", CLOUD, BEGIN + k, lambda m, k=k: m.cloud(clouds[k], time=BEGIN + k)) for k in range(3)]
    path = write_bag(tmp_path / "three", kind, recorded)
    for time, wanted in ((0.0, 0), (0.5, 1), (1.0, 1), (2.0, 2)):
        assert np.allclose(load_bag(path, time=time).points, clouds[wanted], atol=1e-6), time
    with pytest.raises(InputError, match=r"expected a cloud from 2.5 s on, found 3 in 2.0 s"):
        load_bag(path, time=2.5)


def test_what_is_no_finite_point_is_dropped(tmp_path, seen):
    holes = seen.copy()
    holes[5:25] = np.nan
    path = write_bag(tmp_path / "holes", "mcap", [("/points", CLOUD, BEGIN, lambda m: m.cloud(holes))])
    assert load_bag(path).dropped == 20


# Mistakes


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        ("/nothing", "expected topic= to be one of /camera/points, got /nothing"),
        ("/image", "got /image of sensor_msgs/msg/CompressedImage"),
    ],
)
def test_a_wrong_topic_is_told_which_there_are(bag, topic, message):
    with pytest.raises(InputError, match=message) as caught:
        load_bag(bag, topic=topic)
    assert "/camera/points" in str(caught.value) and "\n" not in str(caught.value)


def test_of_several_topics_one_must_be_named(tmp_path, seen):
    recorded = [(topic, CLOUD, BEGIN, lambda m: m.cloud(seen)) for topic in ("/left", "/right")]
    path = write_bag(tmp_path / "two", "sqlite3", recorded)
    with pytest.raises(InputError, match="two: expected topic=, one of /left, /right"):
        load_bag(path)
    assert len(load_bag(path, topic="/right")) > 1000


@pytest.mark.parametrize("kind", KINDS)
def test_bags_without_clouds_and_empty_bags_are_told(tmp_path, kind):
    others = write_bag(tmp_path / "others", kind, [("/image", IMAGE, BEGIN, lambda m: m.image())])
    with pytest.raises(InputError, match=r"expected a topic of sensor_msgs/PointCloud2, found /image \(sensor_msgs"):
        load_bag(others)
    with pytest.raises(InputError, match="^nothing.*: expected") as caught:
        load_bag(write_bag(tmp_path / "nothing", kind, []))
    assert "\n" not in str(caught.value)


def test_an_empty_cloud_is_told(tmp_path):
    recorded = [("/points", CLOUD, BEGIN, lambda m: m.cloud(np.zeros((0, 3))))]
    with pytest.raises(InputError, match="expected at least 100 points, got 0"):
        load_bag(write_bag(tmp_path / "none", "mcap", recorded))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("keep", [0.0, 0.3, 0.8])
def test_a_bag_that_was_cut_off_is_one_line(tmp_path, seen, kind, keep):
    path = write_bag(tmp_path / "cut", kind, recorded_room(seen))
    file = path if path.is_file() else next(file for file in path.iterdir() if file.suffix in (".db3", ".mcap"))
    content = file.read_bytes()
    file.write_bytes(content[: int(keep * len(content))])
    with pytest.raises(InputError, match="^cut") as caught:
        load_bag(path)
    assert "expected" in str(caught.value) and "\n" not in str(caught.value)


def test_files_that_are_no_bags_are_one_line(tmp_path):
    for name, content in (("noise.bag", b"\x00\xff" * 300), ("text.mcap", b"hello"), ("text.db3", b"hello")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=f"^{name}: expected a bag of ROS 1 or ROS 2") as caught:
            load_bag(tmp_path / name)
        assert "\n" not in str(caught.value)


def test_without_rosbags_it_is_said_how_to_get_it(bag, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)  # as Python marks what cannot be imported
    with pytest.raises(InputError, match=r"pip install 'spherefunc-bullet\[ros\]'"):
        load_bag(bag)


# Messages


def test_other_types_orders_and_paddings_of_points():
    messages, points = Messages(ros1=False), np.random.default_rng(0).random((40, 3))
    cloud = messages.cloud(points)
    assert np.allclose(points_of(cloud), points, atol=1e-7)
    own = np.zeros(40, {"names": list("zyx"), "formats": [">f8"] * 3, "offsets": [1, 9, 17], "itemsize": 25})
    own["x"], own["y"], own["z"] = points.T
    fields = [
        messages.make("sensor_msgs/msg/PointField", name=name, offset=offset, datatype=8, count=1)
        for name, offset in (("z", 1), ("y", 9), ("x", 17))
    ]
    changes = {"height": 1, "width": 40, "fields": fields, "is_bigendian": True, "point_step": 25, "row_step": 1000}
    other = messages.cloud(points, **changes, data=own.view(np.uint8))
    assert np.array_equal(points_of(other), points) and colours_of(other) is None


def test_fields_that_only_pad_may_have_one_name():
    messages, points = Messages(ros1=False), np.random.default_rng(0).random((40, 3))
    cloud = messages.cloud(points)
    for offset in (12, 14):
        pad = messages.make("sensor_msgs/msg/PointField", name="_", offset=offset, datatype=2, count=2)
        cloud.fields.append(pad)
    assert np.allclose(points_of(cloud), points, atol=1e-7)
    assert (colours_of(cloud) == [255, 128, 0]).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fields": []}, "expected the fields x, y and z, got none"),
        ({"width": 10_000}, "cut off"),
        ({"point_step": 6, "row_step": 400}, "expected fields within 6 bytes"),
    ],
)
def test_messages_that_contradict_themselves_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        points_of(Messages(ros1=False).cloud(np.zeros((40, 3)), **changes))


@pytest.mark.parametrize("name", ["x", "y", "z", "rgb"])
def test_fields_of_a_type_that_there_is_not(name):
    cloud = Messages(ros1=False).cloud(np.zeros((40, 3)))
    for field in cloud.fields:
        field.datatype = 99 if field.name == name else field.datatype
    if name == "rgb":
        assert colours_of(cloud) is None and len(points_of(cloud)) == 40
    else:
        with pytest.raises(InputError, match=f"expected {name} of a datatype from 1 to 8, got 99"):
            points_of(cloud)


def test_frames_lead_to_the_first_level_one_at_the_time():
    messages, tree = Messages(ros1=False), FrameTree()
    shifted = [np.eye(4) for _ in range(2)]
    shifted[1][0, 3] = 1.0
    tree.add(messages.transform("/base_link", CAMERA, T_level_camera()).transforms, static=True)
    for k in (0, 1):
        tree.add(messages.transform("odom", "base_link", shifted[k], BEGIN + k).transforms)
    name, T, apart = tree.to_level(CAMERA, BEGIN + 0.9)
    assert name == "odom" and np.allclose(T, shifted[1] @ T_level_camera()) and apart == pytest.approx(0.1)
    assert np.allclose(tree.to_level(CAMERA, BEGIN)[1], T_level_camera())
    assert tree.to_level("elsewhere", BEGIN) is None
    assert tree.to_level("robot1/base_link", BEGIN)[0] == "robot1/base_link"


def test_the_last_static_transform_counts():
    """As in tf2: a calibration that was mended is published again."""
    messages, tree = Messages(ros1=False), FrameTree()
    for T in (np.eye(4), T_level_camera()):
        tree.add(messages.transform("base_link", CAMERA, T).transforms, static=True)
    assert np.allclose(tree.to_level(CAMERA, BEGIN)[1], T_level_camera())


@pytest.mark.parametrize("damage", [0.0, np.nan, np.inf])
def test_a_transform_that_is_none_is_ignored(damage):
    """As tf2 ignores it: some drivers send such ones until they know better."""
    messages, tree = Messages(ros1=False), FrameTree()
    never = messages.transform("base_link", CAMERA, np.eye(4)).transforms
    for name in "xyzw":
        setattr(never[0].transform.rotation, name, damage)
    tree.add(never)
    tree.add(messages.transform("base_link", CAMERA, T_level_camera(), BEGIN + 9).transforms)
    assert np.allclose(tree.to_level(CAMERA, BEGIN)[1], T_level_camera())


def test_frames_in_a_circle_end():
    messages, tree = Messages(ros1=False), FrameTree()
    for parent, child in (("a", "b"), ("b", "a")):
        tree.add(messages.transform(parent, child, np.eye(4)).transforms)
    assert tree.to_level("a", BEGIN) is None


# The command


def run(*words):
    return CliRunner().invoke(application(), ["scene", *map(str, words)])


@pytest.mark.slow
def test_scene_reads_a_bag(tmp_path, seen):
    path = write_bag(tmp_path / "room", "mcap", recorded_room(seen))
    about = json.loads(run(path, "--json").stdout)
    assert about["frame"] == "odom" and np.allclose(about["up"], [0, 0, 1])
    members = [name for item in about["objects"] for name, answer in item["functions"].items() if answer["member"]]
    assert "table" in members and "cup" in members


def test_the_files_of_a_bag_have_the_name_of_its_folder(tmp_path, seen, monkeypatch):
    """However the folder is given; what follows a point in it is no ending."""
    path = write_bag(tmp_path / "run.1", "mcap", recorded_room(seen))
    monkeypatch.chdir(path)
    done = run(".", "--out", tmp_path / "found")
    assert done.exit_code == 0 and "run.1: what objects are for" in done.stdout and "-0.00" not in done.stdout
    names = {file.name for file in (tmp_path / "found").iterdir()}
    assert names == {"run.1.json", "run.1_labelled.ply", "run.1.png", "run.1.html"}


@pytest.mark.slow
def test_options_of_bags_are_for_bags(tmp_path, bag):
    np.savetxt(tmp_path / "room.xyz", np.random.default_rng(0).random((500, 3)))
    for words in ((tmp_path / "room.xyz", "--topic", "/points"), (tmp_path / "room.xyz", "--time", 3)):
        assert isinstance(run(*words).exception, InputError)
    missing = run(tmp_path / "drive", "--topic", "/points").exception
    assert "drive: expected a bag of ROS 1 or 2, found nothing of that name" in str(missing)
    assert "--intrinsics" in str(run(bag, "--intrinsics", "camera.json").exception)


# The node


def found(function: str, turn: Rotation) -> FoundObject:
    box = Box(center=np.zeros(3), size=np.array([1.0, 0.6, 0.4]), yaw=0.0)
    corners = turn.apply(box.corners) + [1.0, 2.0, 3.0]
    return FoundObject(
        functions=frozenset({function} - {""}), scores={"cup": 0.2, "table": 0.9}, box=box, corners=corners,
        points=np.zeros((1, 3)),
    )  # fmt: skip


def test_boxes_have_the_pose_of_their_corners():
    turn = Rotation.from_euler("xyz", [0.3, -0.2, 1.1])
    (box,) = boxes_of([found("table", turn), found("", turn)])
    assert (box.function, box.score) == ("table", 0.9)
    assert np.allclose(box.position, [1, 2, 3]) and np.allclose(box.size, [1.0, 0.6, 0.4])
    assert np.allclose((Rotation.from_quat(box.orientation) * turn.inv()).magnitude(), 0, atol=1e-6)


def blank(store, name: str):
    """Return a message of a type with nothing in it, as rclpy makes it."""
    values = {}
    for field, (kind, about) in store.fielddefs[name][1]:
        empty = {"string": "", "bool": False}
        if kind.name == "BASE":
            values[field] = empty.get(about[0], 0)
        elif kind.name == "NAME":
            values[field] = blank(store, about)
        else:
            values[field] = np.zeros(0, np.uint8) if about[0][1][0] in ("uint8", "octet") else []
    return store.types[name](**values)


def node_module():
    specification = importlib.util.spec_from_file_location("functional_objects", NODE)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_a_marker_is_one_that_ros_takes():
    store = get_typestore(Stores.ROS2_HUMBLE)
    (box,) = boxes_of([found("table", Rotation.identity())])
    marker = fill_marker(blank(store, "visualization_msgs/msg/Marker"), box, 7)
    sent = store.serialize_cdr(marker, "visualization_msgs/msg/Marker")
    heard = store.deserialize_cdr(sent, "visualization_msgs/msg/Marker")
    assert (heard.ns, heard.id, heard.text) == ("table", 7, "table 0.90")
    assert (heard.type, heard.action) == (heard.CUBE, heard.ADD)
    assert dataclasses.astuple(heard.scale)[:3] == pytest.approx((1.0, 0.6, 0.4))


@pytest.mark.parametrize("heading", [0.0, 90.0, 200.0])
def test_an_arrow_points_the_way_that_a_sitter_faces(heading):
    store = get_typestore(Stores.ROS2_HUMBLE)
    at, up = np.array([1.0, 2.0, 0.45]), np.array([0.0, 0.0, 1.0])
    known = {"normal": up, "region": (), "area": 0.2, "height": 0.45, "clearance": None, "score": 0.9}
    place = Place(kind="sit", function="sittable", position=at, heading_deg=heading, **known)
    marker = fill_arrow(blank(store, "visualization_msgs/msg/Marker"), place, 0)
    turn = marker.pose.orientation
    x, _, z = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix().T
    assert np.allclose(x, [np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0]) and np.allclose(z, up)
    assert (marker.type, marker.pose.position.z) == (marker.ARROW, 0.45)


def test_an_arrow_follows_a_heading_also_where_x_is_nearly_up():
    """In the frame of a camera that is mounted on its side, headings count from y."""
    store, up = get_typestore(Stores.ROS2_HUMBLE), np.array([np.cos(0.1), np.sin(0.1), 0.0])
    to_scan = Similarity(np.column_stack([[0, 0, 1], np.cross(up, [0, 0, 1]), up]), 1.0, np.zeros(3))
    known = {"region": (), "area": 0.2, "height": 0.45, "clearance": None, "score": 0.9}
    seat = Place(kind="sit", function="sittable", position=np.array([1.0, 2.0, 0.45]), heading_deg=30.0, **known)
    marker = fill_arrow(blank(store, "visualization_msgs/msg/Marker"), seat.moved(to_scan), 0)
    turn = marker.pose.orientation
    ahead = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()[:, 0]
    assert np.allclose(ahead, to_scan.rotation @ [np.cos(np.pi / 6), np.sin(np.pi / 6), 0])


@pytest.mark.slow
def test_the_node_answers_a_recorded_cloud(tmp_path, seen):
    from rosbags.highlevel import AnyReader

    path, store = write_bag(tmp_path / "room", "mcap", recorded_room(seen)), get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([path]) as reader:
        heard = {known.topic: reader.deserialize(raw, known.msgtype) for known, _, raw in reader.messages()}
    node, cloud = node_module(), heard["/camera/points"]
    points, up = node.level_points(cloud, heard["/tf_static"].transforms[0].transform)
    markers = node.markers_of(points, up, cloud.header, lambda: blank(store, "visualization_msgs/msg/Marker"))
    assert markers[0].action == markers[0].DELETEALL
    assert {"table", "cup", "place to pour"} <= {marker.ns for marker in markers[1:]}
    assert all(marker.header.frame_id == CAMERA for marker in markers)
    array = store.types["visualization_msgs/msg/MarkerArray"](markers=markers)
    assert store.serialize_cdr(array, "visualization_msgs/msg/MarkerArray")
    assert node.level_points(cloud, None)[1] == "auto"


def test_the_node_is_short():
    assert len(NODE.read_text().splitlines()) < 100
