"""Vehicle dynamics."""

from spacecraft_gnc.dynamics.rigid_body import RigidBody, state_units

__all__ = ["RigidBody", "state_units"]
