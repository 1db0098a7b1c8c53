"""Flight recordings: raw CDR bytes in, MCAP bags out, and bags read back as trajectories.

ROS-free: neither rclpy nor a message package is needed to write or to read a bag. The modules are
imported one by one, so that a recorder does not load what only a reader needs.
"""

from typing import Final

BAG_FOLDER: Final = "bag"
"""Name of the bag in the folder of a run of ``gnc launch``."""
RUN_SCENARIO: Final = "scenario.yaml"
"""Name of the scenario that flew, beside it."""
