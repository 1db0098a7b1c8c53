"""All nodes of the graph in one process and one executor: the fastest lockstep."""

from __future__ import annotations

import sys
from functools import partial

from rclpy.utilities import remove_ros_args

from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.recorder import RecorderNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode
from spacecraft_gnc.signals.members import agent_of, role_of

_START_ORDER = (RecorderNode, GovernorNode, ControllerNode, PlantNode)


def main() -> int:
    """Run the nodes named on the command line, or all of them, until the plant has finished.

    A name may be relative to the graph, such as ``sc1/nmpc_controller``.
    """
    names = remove_ros_args(sys.argv)[1:]
    nodes = [
        partial(kind, f"/{agent_of(name)}" if agent_of(name) else None)
        for kind in _START_ORDER
        for name in names or [kind.ROLE]
        if role_of(name) == kind.ROLE
    ]
    arguments = [argument for argument in sys.argv if argument not in names]
    return run(*nodes, arguments=arguments)


if __name__ == "__main__":
    raise SystemExit(main())
