"""Deputy spacecraft that docks with a tumbling chief."""
