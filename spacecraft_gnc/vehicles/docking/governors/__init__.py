"""Governor laws of the docking vehicle."""
