"""A small campaign of short flights."""

from __future__ import annotations

SHORT = {"plant.duration": 8.0, "launcher.cut_short": True}  # 20 control steps
VARIATIONS = """
runs: 12
vary:
  plant.initial_rotation_vector: {distribution: rotation, max_angle_deg: 40.0}
  plant.inertia: {distribution: inertia, factor: 0.1}
  nmpc_controller.horizon: {distribution: choice, values: [5, 8]}
pass: final_error_deg < 15 and max_torque < 0.011
worst: 2
"""
