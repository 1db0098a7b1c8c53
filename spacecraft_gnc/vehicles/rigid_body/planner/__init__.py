"""Plans of transfers: what a scenario asks for, how they are told, read, shown and flown."""
