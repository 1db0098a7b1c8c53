"""A bag audited: integrated again, and every command certified afresh."""
