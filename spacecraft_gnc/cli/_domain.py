"""Selection of the ROS graph that a command joins."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Annotated, ClassVar

import typer

from spacecraft_gnc.errors import LaunchError, ParameterError
from spacecraft_gnc.launcher import domain, environment

DomainOption = Annotated[
    int | None,
    typer.Option(
        "--domain-id",
        metavar="N",
        min=0,
        max=232,
        help="ROS_DOMAIN_ID of the graph [the variable, else that of the one `gnc launch`].",
    ),
]


AgentOption = Annotated[
    str,
    typer.Option(
        "--namespace",
        metavar="NAME",
        help="Of the spacecraft, out of several; a craft's means its flight.",
    ),
]


class AmbiguousDomain(LaunchError):
    """Several graphs run, and none was named."""

    exit_code: ClassVar[int] = 2


def choose_domain(given: int | None) -> int:
    """Return the domain to join: the one given, ROS_DOMAIN_ID, or that of the only launched graph.

    Raises
    ------
    AmbiguousDomain
        Several graphs were launched on this machine.
    """
    if given is not None:
        return given
    if os.environ.get(environment.DOMAIN_ID):
        return environment.domain_id(os.environ)
    graphs = list(domain.running_graphs())
    if len(graphs) > 1:
        listed = ", ".join(f"{g.domain_id} ({g.about.get('scenario', '?')})" for g in graphs)
        raise AmbiguousDomain(
            f"--domain-id: received nothing while {len(graphs)} graphs run: {listed}; required the "
            "one you mean; add --domain-id N"
        )
    return graphs[0].domain_id if graphs else 0


def agents_on(domain_id: int) -> list[str]:
    """Return the agents of a launched graph; none where it has one vehicle, or no launcher."""
    return str(domain.about(domain_id).get("agents", "")).split()


def require_namespace(namespace: str, domain_id: int) -> None:
    """Refuse a namespace in which a launched graph has no spacecraft.

    Raises
    ------
    ParameterError
        With the agents and the craft that there are.
    """
    known = str(domain.about(domain_id).get("craft", "")).split()
    if known and namespace.strip("/") not in ("", *agents_on(domain_id), *known):
        listed = ", ".join(f"/{name}" for name in (*agents_on(domain_id), *known))
        raise ParameterError(
            f"--namespace: received {namespace!r} while {listed} fly; required one of these, or "
            "none for the flight of all; leave it out"
        )


def tell_choice(what: str, agents: Sequence[str]) -> None:
    """Tell which of several spacecraft is shown where none was named: the first."""
    listed = ", ".join(f"/{agent}" for agent in agents)
    text = f"holds several spacecraft ({listed}); shows the first; name another with --namespace"
    print(f"note: {what}: {text}", file=sys.stderr)


def find_domain(given: int | None) -> int | None:
    """Return the domain to join as `choose_domain` does, but None where no graph runs, or several.

    For those who wait for a graph.
    """
    if given is not None or os.environ.get(environment.DOMAIN_ID):
        return choose_domain(given)
    graphs = list(domain.running_graphs())
    return graphs[0].domain_id if len(graphs) == 1 else None
