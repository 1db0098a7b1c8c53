"""Campaigns: many seeded flights of one scenario, each of which can be flown again alone."""
