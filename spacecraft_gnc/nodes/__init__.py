"""ROS 2 nodes: thin hosts around the ROS-free cores."""
