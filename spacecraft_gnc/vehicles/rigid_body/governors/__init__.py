"""Governor laws of a rigid body: what builds each one from a scenario."""
