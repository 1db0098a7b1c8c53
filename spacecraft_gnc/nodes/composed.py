"""All nodes of the graph in one process and one executor: the fastest lockstep."""

from __future__ import annotations

import sys

from rclpy.utilities import remove_ros_args

from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.recorder import RecorderNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode

_START_ORDER = (RecorderNode, GovernorNode, ControllerNode, PlantNode)


def main() -> int:
    """Run the nodes named on the command line, or all of them, until the plant has finished."""
    names = remove_ros_args(sys.argv)[1:]
    node_types = [t for t in _START_ORDER if not names or t.ROLE in names]
    arguments = [argument for argument in sys.argv if argument not in names]
    return run(*node_types, arguments=arguments)


if __name__ == "__main__":
    raise SystemExit(main())
