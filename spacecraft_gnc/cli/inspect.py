"""``gnc inspect``: look at a live graph."""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    RunFailed,
    print_json,
    print_table,
)
from spacecraft_gnc.cli._domain import (
    AgentOption,
    DomainOption,
    agents_on,
    choose_domain,
    require_namespace,
    tell_choice,
)
from spacecraft_gnc.cli._help import App
from spacecraft_gnc.cli._inspect_messages import JsonLinesOption, delay, echo, hz
from spacecraft_gnc.cli._inspect_params import NodeArgument, params

inspect = App(
    help="Look at a live graph: its nodes, topics, messages, rates, parameters, life cycles.",
    no_args_is_help=True,
)
_WINDOW = 2.0  # [s] wall over which `topics --rates` counts


@inspect.command()
def nodes(domain_id: DomainOption = None, as_json: JsonOption = False) -> None:
    """List the nodes."""
    from spacecraft_gnc.ros.graph import GraphView

    with GraphView(choose_domain(domain_id)) as view:
        view.discover()
        names = view.nodes()
        _require(names, "node", view.domain_id)
    if as_json:
        print_json({"domain_id": view.domain_id, "nodes": names})
    else:
        print("\n".join(names))


@inspect.command()
def topics(
    qos: Annotated[
        bool, typer.Option("--qos", help="Show who publishes and listens, and how reliably.")
    ] = False,
    rates: Annotated[
        bool, typer.Option("--rates", help="Listen for two seconds and show the rates.")
    ] = False,
    domain_id: DomainOption = None,
    as_json: JsonOption = False,
) -> None:
    """List the topics with type, publishers and subscribers."""
    from spacecraft_gnc.ros.endpoints import misfits
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.rates import measure_all

    with GraphView(choose_domain(domain_id)) as view:
        view.discover()
        found = [info._asdict() for info in view.topics()]
        _require(view.nodes(), "node", view.domain_id)
        if qos:
            for entry in found:
                ends = (view.publishers(entry["name"]), view.subscribers(entry["name"]))
                entry["published_by"], entry["heard_by"] = ([_end(e) for e in es] for es in ends)
                entry["problems"] = misfits(*ends)
        if rates:
            published = [entry["name"] for entry in found if entry["publishers"]]
            measured = measure_all(view, published, _WINDOW)
            for entry in found:
                rate = measured.get(entry["name"])
                entry["hz"] = None if rate is None else rate.messages / _WINDOW
                entry["bytes_per_second"] = None if rate is None else rate.bytes_per_second
    if as_json:
        print_json({"domain_id": view.domain_id, "topics": found})
        return
    print_table((entry["name"], _topic_text(entry, rates)) for entry in found)
    if qos:
        _print_ends(found)


@inspect.command()
def lifecycle(
    node: NodeArgument,
    transition: Annotated[
        str | None,
        typer.Argument(metavar="TRANSITION", help="Go through this one, e.g. cleanup."),
    ] = None,
    domain_id: DomainOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show a node's state and the transitions out of it, or go through one."""
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.remote import RemoteLifecycle

    with GraphView(choose_domain(domain_id)) as view:
        remote = RemoteLifecycle(view, view.find_node(node))
        if transition is not None:
            remote.change(transition)
        state, known = remote.state(), remote.transitions()
    if as_json:
        print_json({"node": remote.name, "state": state, "transitions": known})
        return
    print(f"{remote.name}: {state}")
    print_table((name, f"to {goal}") for name, goal in known.items())


@inspect.command()
def watch(
    once: Annotated[bool, typer.Option("--once", help="Print one frame and end.")] = False,
    timeout: Annotated[
        float, typer.Option(min=0.0, metavar="S", help="Patience for a state [s].")
    ] = 10.0,
    namespace: AgentOption = "",
    domain_id: DomainOption = None,
    as_json: JsonLinesOption = False,
) -> None:
    """Watch a flight to its end: state, error, torque, solver, governor, rates."""
    from spacecraft_gnc.cli._dashboard import watch as show

    style = "json" if as_json else "live" if sys.stdout.isatty() and not once else "plain"
    chosen = choose_domain(domain_id)
    require_namespace(namespace, chosen)
    agents = [] if namespace else agents_on(chosen)
    if agents:
        tell_choice(f"ROS_DOMAIN_ID={chosen}", agents)
        namespace = agents[0]
    show(chosen, namespace, style=style, once=once, patience=timeout)


inspect.command()(echo)
inspect.command()(hz)
inspect.command()(delay)
inspect.add_typer(params, name="params")


def _require(found: list[Any], what: str, domain_id: int) -> None:
    if not found:
        raise RunFailed(
            f"no {what} on ROS_DOMAIN_ID={domain_id}; required a live graph; start one with `gnc "
            "launch`, or name its domain with --domain-id"
        )


def _end(end: Any) -> dict[str, str]:
    return {"node": end.node, "type": end.type, "qos": end.qos_text}


def _topic_text(entry: dict[str, Any], rates: bool) -> str:
    text = (
        f"{', '.join(entry['types'])}  {entry['publishers']} publish, "
        f"{entry['subscribers']} subscribe"
    )
    if not rates:
        return text
    if entry["hz"] is None:
        return f"{text}, rate unknown" if entry["publishers"] else text
    return f"{text}, {entry['hz']:.1f} Hz, {entry['bytes_per_second'] / 1e3:.1f} kB/s"


def _print_ends(found: list[dict[str, Any]]) -> None:
    for entry in found:
        print(entry["name"])
        rows = [(f"+ {e['node']}", e["qos"]) for e in entry["published_by"]]
        rows += [(f"- {e['node']}", e["qos"]) for e in entry["heard_by"]]
        print_table([*rows, *(("problem", text) for text in entry["problems"])])
