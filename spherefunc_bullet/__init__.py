"""Tells what an object is for from how spheres come to rest on it (after Hinkle and Olson, IROS 2013).

import spherefunc_bullet as sf

answer = sf.classify(points, units="mm", up="y")          # a path, an array, an Open3D or trimesh object
objects = sf.find_objects(scan)                            # each with .box, .functions, .scores, .points

cloud = sf.load_cloud("chair.ply")                        # metres, z up, on the ground
result = sf.make_simulator("fast").drop(cloud, sf.DropSettings(radius=0.02), seed=0)
model = sf.FunctionClassifier(simulator="fast").fit(objects, functions)
"""

import lazy_loader

# Names are imported when they are first used, so that the command line starts at once; `__init__.pyi` lists them.
__version__ = "1.0.1"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
