"""Flights as messages of ROS 2, in files that need no ROS."""
