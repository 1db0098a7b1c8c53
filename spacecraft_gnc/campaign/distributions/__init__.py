"""Distributions of the parameters that a campaign varies: numbers in [0, 1) to a value."""
