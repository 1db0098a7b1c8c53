"""Audit of flights of a spacecraft with wheels."""
