"""Metrics of a flight: what its summary, its table and its JSON say."""
