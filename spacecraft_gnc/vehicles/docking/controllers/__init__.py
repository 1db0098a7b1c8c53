"""Methods of the docking vehicle."""
