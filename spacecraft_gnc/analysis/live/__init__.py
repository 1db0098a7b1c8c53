"""Live view of a flight: its pictures and the servers that show them."""
