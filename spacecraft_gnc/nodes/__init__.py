"""ROS 2 nodes: thin hosts around the ROS-free cores."""

import spacecraft_gnc.ros  # noqa: F401 - refuses a missing middleware before rclpy is imported
from spacecraft_gnc.extras import require_ros

require_ros()  # before a scenario is loaded
