"""Controllers of the formation."""
