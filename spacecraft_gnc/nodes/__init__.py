"""ROS 2 nodes around the ROS-free cores; rclpy and message packages are imported here only."""
