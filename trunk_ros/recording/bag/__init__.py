"""Bags of rosbag2 and ROS 1."""
