"""``gnc inspect``: look at a live graph."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from spacecraft_gnc.cli._common import JsonOption, RunFailed, print_json, print_table
from spacecraft_gnc.cli._domain import DomainOption, choose_domain

inspect = typer.Typer(
    help="Look at a live graph: its nodes, topics, messages and rates.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    no_args_is_help=True,
)
TopicArgument = Annotated[str, typer.Argument(metavar="TOPIC", help="Name, e.g. attitude_state.")]
_SHOWN = 9  # elements of an array that are printed


@inspect.command()
def nodes(domain_id: DomainOption = None, as_json: JsonOption = False) -> None:
    """List the nodes."""
    from spacecraft_gnc.nodes._graph import GraphView

    with GraphView(choose_domain(domain_id)) as view:
        view.discover()
        names = view.nodes()
        _require(names, "node", view.domain_id)
    if as_json:
        print_json({"domain_id": view.domain_id, "nodes": names})
    else:
        print("\n".join(names))


@inspect.command()
def topics(domain_id: DomainOption = None, as_json: JsonOption = False) -> None:
    """List the topics with type, publishers and subscribers."""
    from spacecraft_gnc.nodes._graph import GraphView

    with GraphView(choose_domain(domain_id)) as view:
        view.discover()
        found = view.topics()
        _require(view.nodes(), "node", view.domain_id)
    if as_json:
        print_json({"domain_id": view.domain_id, "topics": [info._asdict() for info in found]})
        return
    print_table(
        (i.name, f"{', '.join(i.types)}  {i.publishers} publish, {i.subscribers} subscribe")
        for i in found
    )


@inspect.command()
def echo(
    topic: TopicArgument,
    count: Annotated[int, typer.Option("--count", "-n", min=0, help="0: until Ctrl-C.")] = 0,
    timeout: Annotated[float, typer.Option(min=0.0, help="Patience for a message [s].")] = 10.0,
    domain_id: DomainOption = None,
) -> None:
    """Print the messages of a topic as YAML."""
    from spacecraft_gnc.nodes._graph import GraphView

    printed = 0

    def show(message: Any) -> None:
        nonlocal printed
        if count and printed >= count:
            return
        printed += 1
        print(_as_text(message), flush=True)

    with GraphView(choose_domain(domain_id)) as view:
        name = view.subscribe(topic, show)
        view.spin_until(lambda: printed > 0, timeout)
        if not printed:
            raise RunFailed(
                f"{name}: no message within {timeout:g} s on ROS_DOMAIN_ID={view.domain_id}; "
                "required at least one; is the flight over? Wait longer with --timeout"
            )
        view.spin_until(lambda: 0 < count <= printed)


@inspect.command()
def hz(
    topic: TopicArgument,
    window: Annotated[float, typer.Option(min=0.1, help="Wall time of one figure [s].")] = 1.0,
    count: Annotated[int, typer.Option("--count", "-n", min=0, help="0: until Ctrl-C.")] = 0,
    domain_id: DomainOption = None,
) -> None:
    """Print the rate of a topic in wall time."""
    from spacecraft_gnc.nodes._graph import GraphView

    with GraphView(choose_domain(domain_id)) as view:
        for number, rate in enumerate(view.measure(topic, window), start=1):
            print(
                f"{rate.hz:.1f} Hz ({rate.messages} messages, period "
                f"{rate.period_min * 1e3:.2f} to {rate.period_max * 1e3:.2f} ms)",
                flush=True,
            )
            if number == count:
                return


def _require(found: list[Any], what: str, domain_id: int) -> None:
    if not found:
        raise RunFailed(
            f"no {what} on ROS_DOMAIN_ID={domain_id}; required a live graph; start one with `gnc "
            "launch`, or name its domain with --domain-id"
        )


def _as_text(message: Any) -> str:
    """Return a message as YAML, one document, long arrays cut short."""
    return "\n".join(["---", *_lines(message, "")])


def _lines(message: Any, indent: str) -> list[str]:
    lines = []
    for name in message.get_fields_and_field_types():
        value = getattr(message, name)
        if hasattr(value, "get_fields_and_field_types"):
            lines += [f"{indent}{name}:", *_lines(value, indent + "  ")]
        elif hasattr(value, "__len__") and not isinstance(value, str | bytes):
            lines += _array_lines(name, list(value), indent)
        else:
            lines.append(f"{indent}{name}: {value!r}")
    return lines


def _array_lines(name: str, values: list[Any], indent: str) -> list[str]:
    if values and hasattr(values[0], "get_fields_and_field_types"):
        lines = [f"{indent}{name}:"]
        for value in values:
            first, *rest = _lines(value, indent + "  ")
            lines += [f"{indent}- {first.strip()}", *rest]
        return lines
    shown = ", ".join(repr(float(v) if hasattr(v, "dtype") else v) for v in values[:_SHOWN])
    more = f", ... {len(values)} in all" if len(values) > _SHOWN else ""
    return [f"{indent}{name}: [{shown}{more}]"]
