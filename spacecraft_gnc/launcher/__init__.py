"""Starts the nodes of a scenario, watches them, ends them; ROS-free but for what nodes/ lends."""
