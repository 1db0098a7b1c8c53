"""Spacecraft with reaction wheels: gyrostat dynamics, plant, feedback law and metrics."""
