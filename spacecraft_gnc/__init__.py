"""Constrained spacecraft attitude control: fast NMPC on SO(3) and the ROS 2 graph that flies it."""

__version__ = "0.1.0"

SILENT_COMPILER = "SPACECRAFT_GNC_SILENT_COMPILER"
"""Environment variable: 1 where nothing is to be said about kernels that are being compiled."""
