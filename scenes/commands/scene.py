"""``spherefunc scene``: find and classify the objects of a scanned room (paper, §IV-C, Fig. 6)."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spherefunc_bullet.commands.options import Json, Model, Units, require_beside
from spherefunc_bullet.console import print_json, say, show
from spherefunc_bullet.errors import InputError, one_line
from spherefunc_bullet.formats.units import Stopwatch, format_length, parse_length

from ..settings import POOL, RECOGNITION

if TYPE_CHECKING:
    from spherefunc_bullet.clouds.cloud import Cloud
    from spherefunc_bullet.function_model import FunctionModel
    from spherefunc_bullet.places.place import Place, Similarity

    from ..fusion.point_map import FusionSettings
    from ..recognition.recognition import Room
    from ..scans.scan import Scan

Completion = Annotated[
    str | None, typer.Option(help="How objects are completed: smooth,top,bottom,sides,mirror (any of them), or none.")
]
Proposals = Annotated[
    str | None, typer.Option(help="Sources of proposals: clusters, pools of spheres, or both (the default).")
]


def scene(
    file: Annotated[
        Path | None,
        typer.Argument(readable=False, help="A point cloud, a fused mesh, a depth image, or a bag of ROS 1 or 2."),
    ] = None,
    model: Model = None,
    backend: Annotated[
        str | None, typer.Option(help="Use the model of this simulator that comes with the package.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the JSON, a labelled PLY, a picture and an interactive page.")
    ] = None,
    up: Annotated[str, typer.Option(help="auto (by the floor), an axis (z, -y), or numbers x,y,z.")] = "auto",
    units: Units = "auto",
    intrinsics: Annotated[
        Path | None,
        typer.Option(
            help="The depth camera: JSON as Open3D writes it, or a matrix of 3 x 3 numbers; for depth images."
        ),
    ] = None,
    color: Annotated[Path | None, typer.Option(help="The colour image of a depth image.")] = None,
    depth_scale: Annotated[
        float | None, typer.Option(help="Depth values per metre of images of integers. Default: 1000; for TUM's 5000.")
    ] = None,
    frames: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Fuse the depth images of a folder: TUM, 3DMatch, Redwood.")
    ] = None,
    poses: Annotated[
        Path | None, typer.Option(help="The cameras' poses: TUM's lines, or a Redwood .log. Default: odometry.")
    ] = None,
    pose_error: Annotated[
        str | None, typer.Option(help="Deviation of the poses along each axis, or none. Default: 2cm.")
    ] = None,
    every: Annotated[
        int | None, typer.Option(min=0, help="Recognise after every n images; 0: only at the end.")
    ] = None,
    topic: Annotated[str | None, typer.Option(help="A bag's topic of sensor_msgs/PointCloud2.")] = None,
    time: Annotated[
        float | None, typer.Option(help="Use the first cloud from this time on, in seconds after the start of the bag.")
    ] = None,
    complete: Completion = None,
    cluster_tolerance: Annotated[str, typer.Option(help="Largest gap within an object.")] = "2cm",
    min_cluster_size: Annotated[int, typer.Option(help="Minimum number of voxels of an object.")] = 60,
    max_cluster_size: Annotated[int | None, typer.Option(help="Maximum number of voxels of an object.")] = None,
    leaf_size: Annotated[str, typer.Option(help="Voxel size for thinning the scan.")] = "1cm",
    proposals: Proposals = None,
    method: Annotated[
        str | None, typer.Option(help="paper: floor by RANSAC, clusters as they are; needs a model trained that way.")
    ] = None,
    put: Annotated[
        Path | None,
        typer.Option(metavar="OBJECT", help="An object, in metres, to set down: adds poses at which it stands."),
    ] = None,
    places: Annotated[bool, typer.Option("--places", help="Add places to sit, to put and to pour.")] = False,
    json: Json = False,
):
    """Find and label the objects in a scanned room."""
    from spherefunc_bullet.learning.model_file import inference_model, shipped_model

    from ..fusion.frames import open_frames
    from ..fusion.scene_fusion import SceneFusion
    from ..recognition.completion import steps_of
    from ..recognition.examples import recognise_as_paper
    from ..recognition.proposals import kinds_of
    from ..recognition.recognition import recognise
    from ..report.files import room_json
    from ..segmentation.segmentation import Segmentation
    from .places import read_put
    from .scene_frames import EVERY, print_used, require_outputs, scene_of_frames, write_files

    kinds = kinds_of(proposals)
    require_method(method, model, {"--complete": complete, "--proposals": proposals})
    classifier = inference_model(model or shipped_model(backend or "fast", scans=True), backend)
    settings = Segmentation(
        leaf_size=parse_length(leaf_size),
        cluster_tolerance=parse_length(cluster_tolerance),
        min_cluster_size=min_cluster_size,
        **({} if max_cluster_size is None else {"max_cluster_size": max_cluster_size}),
    )
    steps, fused = steps_of(complete), fusion_settings(pose_error)
    alone = {"FILE": file, "--color": color, "--topic": topic, "--time": time, "--method": method}
    alone["--units"] = None if units == "auto" else units
    beside = {"--poses": poses, "--pose-error": pose_error, "--every": every}
    require_beside("--frames", frames is not None, alone, beside)
    if (place := frames or file) is None:
        raise InputError("FILE: expected a scan, or --frames DIR with depth images over time")
    stem = place.resolve().name if os.path.isdir(place) else place.stem  # a folder may be `.`, or run.1 beside run.2
    if out is not None:
        require_outputs(out, place, stem, (model, intrinsics, color, poses, put))
    if frames is None:
        require_source(file, units, {"--intrinsics": intrinsics, "--color": color, "--depth-scale": depth_scale})
    to_put = read_put(put)
    use = partial(places_in, put=to_put) if places or put is not None else lambda scan, room: None
    if frames is not None:
        source = open_frames(frames, poses=poses, intrinsics=intrinsics, depth_scale=depth_scale, report=say)
        fusion = SceneFusion(classifier, fusion=fused, settings=settings, up=up, completion=steps, proposals=kinds)
        warm_up_recognition(classifier)
        rate = EVERY if every is None else every
        return scene_of_frames(fusion, source, frames, every=rate, out=out, json=json, remarks=say_remarks, use=use)
    scan = bag_scan(file, topic, time) or read_scan(file, units, intrinsics, color, depth_scale)
    up = "z" if up == "auto" and scan.level_frame is not None else up
    warm_up_recognition(classifier)
    if method is None:
        room = recognise(scan, classifier, up=up, settings=settings, completion=steps, proposals=kinds)
    else:
        room = recognise_as_paper(scan, classifier, up=up, settings=settings)
    say_remarks(scan, room)
    used = use(scan, room)
    about = room_json(scan, room, used)
    if out is not None:
        write_files(scan, room, out, stem, about, used)
    if json:
        print_json(about | {"file": str(file)})
    else:
        print_room(scan, room)
        print_used(scan.name, used or {})


def require_method(method: str | None, model: Path | None, others: dict[str, str | None]):
    """Raise InputError for an unknown method, or for the paper's with a model or options of another method."""
    if method not in (None, "paper"):
        raise InputError(f"--method {method!r}: expected paper, or nothing for the default")
    if method is not None and model is None:
        trained = "spherefunc train household --method paper --out paper.npz"
        raise InputError(f"--method paper: expected --model with one learnt by that method; {trained} makes one")
    for name, value in others.items():
        if method is not None and value is not None:
            raise InputError(f"{name}: expected without --method paper, which takes clusters as they are")


def fusion_settings(pose_error: str | None) -> FusionSettings:
    """Return how depth images are fused whose poses are off by a length, such as ``2cm``; ``none``: they are exact."""
    from ..fusion.point_map import FusionSettings

    if pose_error is None:
        return FusionSettings()
    return FusionSettings(pose_error=0.0 if pose_error == "none" else parse_length(pose_error))


def bag_scan(file: Path, topic: str | None, time: float | None) -> Scan | None:
    """Return the scan of a cloud in a bag, None if the file is no bag."""
    from ..ros.bag import is_bag, load_bag

    if not 0.0 <= (time or 0.0) < 1e9:
        raise InputError(f"--time {time:g}: expected seconds after the start of the bag")
    if is_bag(file):
        return load_bag(file, topic=topic, time=time or 0.0, report=say)
    for option, value in (("--topic", topic), ("--time", time)):
        if value is not None and not file.exists():
            raise InputError(f"{file}: expected a bag of ROS 1 or 2, found nothing of that name")
        if value is not None:
            raise InputError(f"{option}: expected with a bag of ROS 1 or 2, got {file.name}")
    return None


def require_source(file: Path, units: str, images: dict[str, object]):
    """Raise InputError for a folder that is no bag, and for options that do not go with the file."""
    from ..ros.bag import is_bag
    from ..scans.depth_image import is_image_file, require_depth_image

    image, bag = is_image_file(file), is_bag(file)
    if os.path.isdir(file) and not bag:
        came = "got a folder without metadata.yaml; --frames reads depth images from one"
        raise InputError(f"{one_line(file)}: expected a file, or a bag of ROS 2, {came}")
    require_depth_image(image, file.name, images)
    if units != "auto" and (image or bag):
        raise InputError(f"--units: expected with a point cloud or a mesh, got {file.name}")


def read_scan(file: Path, units: str, intrinsics: Path | None, color: Path | None, depth_scale: float | None) -> Scan:
    """Return the scan of a point cloud's or a depth image's file."""
    from ..scans.depth_image import is_image_file, load_depth_image
    from ..scans.scan import load_scan

    if not is_image_file(file):
        return load_scan(file, units=units, report=say)
    return load_depth_image(file, intrinsics=intrinsics, color=color, depth_scale=depth_scale, report=say)


def warm_up_recognition(classifier: FunctionModel):
    """Compile or load all code, so that the times of stages do not include it."""
    from spherefunc_bullet.settling.settling import warm_up
    from spherefunc_bullet.simulator import isolated, make_simulator

    from ..recognition.recognition import compile_kernels

    compile_kernels()
    simulator = make_simulator(classifier.simulator)
    if not isolated(simulator):
        warm_up(simulator)


def say_remarks(scan: Scan, room: Room):
    """Print remarks on stderr about results that the user may not expect."""
    remarks = {
        "table top": "no floor is seen; the table top that carries the scene serves as ground",
        "assumed": "neither a floor nor a table top was found under the scene; its lowest point serves as ground",
        "given": "no floor is seen; the lowest point along --up serves as ground",
    }
    if len(scan) > RECOGNITION.many:
        say(f"{scan.name}: {len(scan):,} points, more than needed; thinned to voxels of {format_length(POOL.spacing)}")
    if room.levelling.source in remarks:
        say(f"{scan.name}: {remarks[room.levelling.source]}")
    if not room.objects:
        say(f"{scan.name}: no objects found; is the room empty, or --min-cluster-size too large?")


def places_in(scan: Scan, room: Room, put: tuple[Cloud, Similarity] | None) -> dict[int | None, list[Place]]:
    """Return the places of each object of a room; the time is added to the room's stages."""
    from ..recognition.objects import places_in_room

    watch, found = Stopwatch(), places_in_room(scan, room, put)
    watch.lap("places")
    room.stages.update(watch.seconds)
    return found


def print_room(scan: Scan, room: Room):
    """Print the objects with a function, and the seconds of each stage."""
    from ..report.files import object_cells
    from .scene_frames import position_text, print_inferred, print_objects

    rows = []
    for item in room.objects:
        if item.main_function is not None:
            cells = object_cells(room, item, item.main_function, bool(room.doubts(item)))
            rows.append([str(item.id), *cells, position_text(room.box_in_scan(item.box).center), f"{len(item.points)}"])
    counts = print_objects(scan.name, room, rows, "object", "points")
    show(f"{counts}; ground: {room.levelling.source}")
    print_inferred(room.inferred)
    stages = ", ".join(f"{name} {seconds:.2f}" for name, seconds in room.stages.items())
    show(f"seconds: {stages}; together {sum(room.stages.values()):.2f}")
