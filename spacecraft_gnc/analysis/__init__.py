"""Numbers and figures of a flown trajectory, from a bag or from an offline run."""
