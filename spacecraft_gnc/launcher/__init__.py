"""Launcher: starts, monitors and stops the nodes of a scenario."""
