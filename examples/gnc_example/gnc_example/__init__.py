"""A control method and a vehicle that plug into spacecraft_gnc by entry points."""
