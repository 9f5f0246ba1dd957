"""Flights as messages of ROS 2, written without ROS."""
