"""All nodes in one process and one executor, for the fastest lockstep."""

from __future__ import annotations

import sys
from functools import partial

from rclpy.utilities import remove_ros_args

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.nodes._runner import report, run
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.recorder import RecorderNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode
from spacecraft_gnc.ros.parameters import command_line, controllers_in
from spacecraft_gnc.scenario.agents import agents_in
from spacecraft_gnc.signals.members import Place, role_of, space_of

_START_ORDER = (RecorderNode, GovernorNode, ControllerNode, PlantNode)


def main() -> int:
    """Run the nodes named on the command line, or all of them, until the plant has finished.

    A name may be relative to the graph, such as ``sc1/nmpc_controller``.
    """
    named = remove_ros_args(sys.argv)[1:]
    try:
        names = named or _all_nodes()
    except GncError as error:
        report(error)
        return error.exit_code
    nodes = [
        partial(kind, f"/{space_of(name)}" if space_of(name) else None)
        for kind in _START_ORDER
        for name in names
        if role_of(name) == kind.ROLE
    ]
    arguments = [argument for argument in sys.argv if argument not in named]
    return run(*nodes, arguments=arguments)


def _all_nodes() -> list[str]:
    """Return the nodes that the parameter files are for."""
    sections = command_line(sys.argv)
    places = [Place("", agent) for agent in agents_in(sections) or ("",)]
    governors = [place.within_graph(GovernorNode.ROLE) for place in places]
    return [RecorderNode.ROLE, *governors, *controllers_in(sections), PlantNode.ROLE]


if __name__ == "__main__":
    raise SystemExit(main())
