"""Flight recordings: raw CDR bytes in, MCAP bags out, and bags read back as trajectories.

ROS-free: neither rclpy nor a message package is needed to write or to read a bag. The modules are
imported one by one, so that a recorder does not load what only a reader needs.
"""
