"""Vehicles: one room each, found by the entry-point group ``spacecraft_gnc.vehicles``."""
