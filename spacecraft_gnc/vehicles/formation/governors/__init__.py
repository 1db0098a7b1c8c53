"""Governors of the formation."""
