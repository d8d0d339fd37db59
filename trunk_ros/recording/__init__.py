"""Recordings in and out: bags of ROS 1 and ROS 2, and CSV by a mapping. Nothing here needs ROS."""
