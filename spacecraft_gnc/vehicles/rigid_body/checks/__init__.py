"""Checks of a rigid body's scenario: whether its values fit together."""
