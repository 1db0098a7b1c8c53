"""Audit of docking flights."""
