"""Parameters of the docking vehicle, by section."""
