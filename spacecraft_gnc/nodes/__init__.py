"""ROS 2 nodes: thin hosts around the ROS-free cores."""

import spacecraft_gnc_msgs  # noqa: F401 - refuses at once where the messages are not built

import spacecraft_gnc.ros  # noqa: F401 - refuses a missing middleware before rclpy is imported
