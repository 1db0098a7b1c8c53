"""Methods of a spacecraft with reaction wheels."""
