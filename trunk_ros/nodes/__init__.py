"""The nodes: the only part of the package that needs ROS 2."""
