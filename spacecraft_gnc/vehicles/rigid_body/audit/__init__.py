"""Audit of the rigid body: its motion, its plans, its decisions."""
