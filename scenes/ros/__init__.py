"""ROS: clouds from recorded bags, and found objects as boxes that a node publishes; nothing here needs ROS itself.

May import `recognition`, `scans` and the shared stack.
"""
