"""ROS 2 beside the nodes: messages, topics, and what the command line uses of rclpy."""

import os
import sys

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher.environment import require_middleware

try:
    require_middleware(os.environ)
except LaunchError as error:  # nobody can catch it: rclpy would end the process, with code 102
    print(f"error: {error}", file=sys.stderr)
    raise SystemExit(error.exit_code) from None
