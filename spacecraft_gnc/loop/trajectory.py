"""Former name of a flight, until its users have moved."""

from spacecraft_gnc.loop.flight import Flight as Trajectory

__all__ = ["Trajectory"]
