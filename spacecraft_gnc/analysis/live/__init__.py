"""A flight as somebody watches it: what is shown, and who serves it."""
