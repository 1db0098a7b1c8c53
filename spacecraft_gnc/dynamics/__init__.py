"""Vehicle dynamics."""

from spacecraft_gnc.dynamics.rigid_body import RigidBody

__all__ = ["RigidBody"]
