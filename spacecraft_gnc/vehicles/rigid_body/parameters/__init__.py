"""Parameters of the rigid body, and the defaults that follow from them."""
