"""Parameters: one declaration each, its value, its ROS 2 YAML form, its problems."""
