"""Plans of attitude transfers in flight: what belongs to a step, and when another plan is due."""
