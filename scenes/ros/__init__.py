"""ROS: clouds out of recorded bags, and what was found as boxes that a node publishes; nothing here needs ROS itself.

May import `recognition`, `scans` and the shared stack.
"""
