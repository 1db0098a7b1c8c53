"""Parameters of a formation scenario, by section."""
