"""Parts that any vehicle composes inside its simulated plant."""
