"""Virtual rooms: objects of a data set on a floor between walls, seen by a virtual Kinect, every point's owner known.

May import `scans`, `household` and the shared stack; the sensors' rooms are recognised elsewhere.
"""
