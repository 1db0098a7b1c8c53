"""Spacecraft that form up on a natural trajectory relative to a circular orbit."""
