"""Constrained spacecraft attitude control: fast NMPC on SO(3) and the ROS 2 graph that flies it."""

__version__ = "0.1.0"
