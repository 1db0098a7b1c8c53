"""``gnc inspect echo``, ``hz`` and ``delay``: messages on a topic, their rate and age."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spacecraft_gnc.cli._common import RunFailed, json_able
from spacecraft_gnc.cli._domain import DomainOption, choose_domain

if TYPE_CHECKING:
    from spacecraft_gnc.ros.graph import GraphView

TopicArgument = Annotated[str, typer.Argument(metavar="TOPIC", help="Name, e.g. attitude_state.")]
CountOption = Annotated[
    int, typer.Option("--count", "-n", min=0, metavar="N", help="0: until Ctrl-C.")
]
TimeoutOption = Annotated[
    float, typer.Option(min=0.0, metavar="S", help="Patience for a message [s].")
]
WindowOption = Annotated[
    float, typer.Option(min=0.1, metavar="S", help="Wall time of one figure [s].")
]
JsonLinesOption = Annotated[
    bool, typer.Option("--json", help="Print one JSON object a line and nothing else.")
]
_SHOWN = 9  # elements of an array that are printed


def echo(
    topic: TopicArgument,
    count: CountOption = 0,
    once: Annotated[bool, typer.Option("--once", help="The same as --count 1.")] = False,
    field: Annotated[
        str | None, typer.Option("--field", metavar="A.B[2]", help="Print this field only.")
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="Print long arrays to their end.")] = False,
    timeout: TimeoutOption = 10.0,
    domain_id: DomainOption = None,
    as_json: JsonLinesOption = False,
) -> None:
    """Print the messages of a topic as YAML."""
    from spacecraft_gnc.ros import messages as _messages
    from spacecraft_gnc.ros.graph import GraphView

    wanted = 1 if once else count
    printed = 0
    refusal: Exception | None = None

    def show(message: Any) -> None:
        nonlocal printed, refusal
        if refusal is not None or (wanted and printed >= wanted):
            return
        try:
            values = _messages.plain(message)
            found = values if field is None else _messages.field(values, field)
        except _messages.FieldRefused as error:  # rclpy would swallow it
            refusal = error
            return
        printed += 1
        if as_json:
            print_json_line(found)
        else:
            print("\n".join(_document(found, math.inf if full else _SHOWN)), flush=True)

    with GraphView(choose_domain(domain_id)) as view:
        name = view.subscribe(topic, show)
        view.spin_until(lambda: printed > 0 or refusal is not None, timeout)
        if not printed and refusal is None and not view.interrupted:
            raise RunFailed(
                f"{name}: no message within {timeout:g} s on ROS_DOMAIN_ID={view.domain_id}; "
                "required at least one; is the flight over? Wait longer with --timeout"
            )
        view.spin_until(lambda: 0 < wanted <= printed or refusal is not None)
    if refusal is not None:
        raise refusal


def hz(
    topic: TopicArgument,
    window: WindowOption = 1.0,
    count: CountOption = 0,
    timeout: TimeoutOption = 10.0,
    domain_id: DomainOption = None,
    as_json: JsonLinesOption = False,
) -> None:
    """Print the rate of a topic in wall time."""
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.rates import measure

    with GraphView(choose_domain(domain_id)) as view:
        rates = measure(view, topic, window, timeout)
        _print_figures(view, topic, rates, _rate_text, count, as_json)


def delay(
    topic: TopicArgument,
    window: WindowOption = 1.0,
    count: CountOption = 0,
    timeout: TimeoutOption = 10.0,
    domain_id: DomainOption = None,
    as_json: JsonLinesOption = False,
) -> None:
    """Print the age of a topic's messages: /clock, or else the wall clock, minus their stamp."""
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.rates import delays

    with GraphView(choose_domain(domain_id)) as view:
        found = delays(view, topic, window, timeout)
        _print_figures(view, topic, found, _delay_text, count, as_json)


def _print_figures(
    view: GraphView,
    topic: str,
    figures: Iterable[Any],
    text: Callable[[Any], str],
    count: int,
    as_json: bool,
) -> None:
    """Print one figure of a topic a line as they come, ``count`` of them (0: until they end)."""
    for number, found in enumerate(figures, start=1):
        if as_json:
            print_json_line({"topic": view.node.resolve_topic_name(topic), **found._asdict()})
        else:
            print(text(found), flush=True)
        if number == count:
            return


def print_json_line(values: Any) -> None:
    """Print one JSON value on a line of its own; NaN and infinity become null."""
    sys.stdout.write(json.dumps(json_able(values), allow_nan=False) + "\n")
    sys.stdout.flush()


def _rate_text(rate: Any) -> str:
    return (
        f"{rate.hz:.1f} Hz ({rate.messages} messages, period "
        f"{rate.period_min * 1e3:.2f} to {rate.period_max * 1e3:.2f} ms)"
    )


def _delay_text(delay: Any) -> str:
    if not delay.messages:
        return "no message"
    ages = f"{delay.mean:.6f} s mean, {delay.least:.6f} to {delay.most:.6f} s"
    if delay.clock == "wall":
        return f"{ages} of wall time ({delay.messages} messages)"
    early = "; negative: a message was here before the tick of its time" if delay.least < 0 else ""
    return (
        f"{ages} of simulated time by /clock, which runs at {delay.speed:.3g} times real time "
        f"({delay.messages} messages{early})"
    )


def _document(value: Any, shown: float) -> list[str]:
    """Return a message, or a field of one, as a YAML document; long arrays are cut short."""
    if isinstance(value, Mapping):
        return ["---", *_lines(value, "", shown)]
    return _array_lines("", value, "", shown) if isinstance(value, list) else [_scalar(value)]


def _lines(values: Mapping[str, Any], indent: str, shown: float) -> list[str]:
    lines = []
    for name, value in values.items():
        if isinstance(value, Mapping):
            lines += [f"{indent}{name}:", *_lines(value, indent + "  ", shown)]
        elif isinstance(value, list):
            lines += _array_lines(f"{name}:", value, indent, shown)
        else:
            lines.append(f"{indent}{name}: {_scalar(value)}")
    return lines


def _array_lines(label: str, values: list[Any], indent: str, shown: float) -> list[str]:
    if values and isinstance(values[0], Mapping):
        lines = [f"{indent}{label}"] if label else []
        for value in values:
            first, *rest = _lines(value, indent + "  ", shown)
            lines += [f"{indent}- {first.strip()}", *rest]
        return lines
    few = values if len(values) <= shown else values[: int(shown)]
    more = f", ... {len(values)} in all" if len(values) > len(few) else ""
    return [
        f"{indent}{label} [{', '.join(map(_scalar, few))}{more}]".lstrip(" " if not label else "")
    ]


def _scalar(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return repr(value)
