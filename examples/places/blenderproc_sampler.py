import blenderproc as bproc  # noqa: I001 - BlenderProc wants this to be a script's first line

# A sampler for BlenderProc: sets an object down where it stands, clear of what stands there already.
#
#     spherefunc places table.ply --put mug.ply --json > places.json
#     blenderproc run blenderproc_sampler.py table.ply mug.ply places.json images/
#
# Blender's Python needs nothing of spherefunc: poses come as JSON, from the frame of the mug's file to the table's.
import json
import random
import sys

import numpy as np


def read_poses(path):
    """Return the poses (4, 4) at which the object stands, the largest margin first."""
    with open(path, encoding="utf-8") as file:
        (row,) = json.load(file)
    return [np.array(pose) for place in row["places"] if place["kind"] == "put" for pose in place.get("poses", [])]


def sampler(poses, seed=0):
    """Return a function that sets an object down at another pose each time, as `bproc.object.sample_poses` takes it."""
    left = list(poses)
    random.Random(seed).shuffle(left)
    return lambda placed: placed.set_local2world_mat(left.pop())


def main(table, put, places, folder):
    """Render a table with the object at one of its poses."""
    bproc.init()
    (ground,), placed = bproc.loader.load_obj(table), bproc.loader.load_obj(put)
    bproc.object.sample_poses(placed, sample_pose_func=sampler(read_poses(places)), objects_to_check_collisions=[])
    light = bproc.types.Light()
    light.set_location([2, -2, 3])
    light.set_energy(300)
    eye, at = np.array([1.5, -1.5, 1.8]), np.mean(ground.get_bound_box(), axis=0)
    turn = bproc.camera.rotation_from_forward_vec(at - eye)
    bproc.camera.add_camera_pose(bproc.math.build_transformation_mat(eye, turn))
    bproc.writer.write_hdf5(folder, bproc.renderer.render())


if __name__ == "__main__":
    main(*sys.argv[1:5])
