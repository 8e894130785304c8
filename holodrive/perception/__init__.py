"""Scan to sectors, de-skewed points, clusters: what a lidar says about the room, in the robot's own frame."""
