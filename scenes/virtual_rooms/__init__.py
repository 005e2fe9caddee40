"""Virtual rooms: objects of a data set on a floor between walls, seen by a virtual Kinect, every point's owner known.

May import `recognition`, whose completion partial views go through, and the shared stack.
"""
