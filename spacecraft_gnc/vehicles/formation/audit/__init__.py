"""Audit of formation flights, by equations and an enumeration of its own."""
