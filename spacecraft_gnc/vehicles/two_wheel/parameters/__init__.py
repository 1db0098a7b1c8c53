"""Parameters of a spacecraft with wheels, and the defaults that follow from them."""
