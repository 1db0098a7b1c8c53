"""Control methods of the rigid body."""
