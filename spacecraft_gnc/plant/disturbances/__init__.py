"""Disturbances: external torques on the body, which the controller does not know."""
