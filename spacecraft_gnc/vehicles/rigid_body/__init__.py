"""Rigid body: a spacecraft turned by a body torque."""
