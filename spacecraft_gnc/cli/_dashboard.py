"""The terminal dashboard of ``gnc inspect watch``."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup
from spacecraft_gnc.cli._common import RunFailed
from spacecraft_gnc.cli._inspect_messages import print_json_line
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.loop.protocols import Source

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.text import Text

    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.live_source import LiveSource

_FRAME_PERIOD: Final = 0.1  # [s] wall between two frames on a terminal
_LINE_PERIOD: Final = 1.0  # [s] wall between two lines elsewhere
_SETUP_PATIENCE: Final = 3.0  # [s] wall for the parameters, which one frame alone would lack
_WIDTH: Final = 80  # characters
_BAR: Final = 15  # characters on each side of zero
_COLOURS: Final = ("green", "cyan", "yellow", "dark_orange", "red", "green")  # by `Source`
_PHASES: Final = {
    Phase.FLYING: "green",
    Phase.WAITING: "yellow",
    Phase.STALE: "red",
    Phase.OVER: "cyan",
}


def watch(domain_id: int, namespace: str, *, style: str, once: bool, patience: float) -> None:
    """Show a flight until it is over, or Ctrl-C.

    Parameters
    ----------
    domain_id
        ROS_DOMAIN_ID of the graph.
    namespace
        Of the spacecraft.
    style
        ``live``: a dashboard; ``plain``: lines; ``json``: one object a line.
    once
        Show one whole frame instead.
    patience
        Wall time to wait for a state [s].

    Raises
    ------
    RunFailed
        No state came.
    """
    from rich.console import Console

    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.live_source import LiveSource

    with GraphView(domain_id) as view:
        source = LiveSource(view, namespace)
        first = _first_picture(view, source, patience)
        if first is None:
            return
        if once:
            first = _whole_picture(view, source)
            if style == "json":
                print_json_line(_json(first, source))
            else:
                Console(highlight=False).print(render(first, source.setup))
        elif style == "live":
            _show_live(view, source)
        else:
            for picture in _pictures(view, source, _LINE_PERIOD):
                if style == "json":
                    print_json_line(_json(picture, source))
                else:
                    print(line(picture), flush=True)


def _first_picture(view: GraphView, source: LiveSource, patience: float) -> Picture | None:
    """Return the first picture with a state; None after Ctrl-C."""
    view.spin_until(lambda: source.heard, patience)
    if source.heard or view.interrupted:
        return source.picture() if source.heard else None
    raise RunFailed(f"{source.picture().note}; required a flight; wait longer with --timeout")


def _whole_picture(view: GraphView, source: LiveSource) -> Picture:
    """Return a picture once parameters and rates are known, or after some patience."""

    def is_whole() -> bool:
        picture = source.picture()
        return bool(source.setup.period > 0.0 and picture.rates and picture.solve)

    view.spin_until(is_whole, _SETUP_PATIENCE)
    return source.picture()


def _pictures(view: GraphView, source: LiveSource, period: float) -> Iterator[Picture]:
    """Yield a picture every ``period`` [s] until the flight is over, or Ctrl-C."""
    while not view.interrupted:
        due = time.monotonic() + period
        picture = source.picture()
        yield picture
        if picture.phase is Phase.OVER:
            return
        view.spin_until(lambda due=due: time.monotonic() >= due)  # type: ignore[misc]


def _show_live(view: GraphView, source: LiveSource) -> None:
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(highlight=False), auto_refresh=False) as live:
        for picture in _pictures(view, source, _FRAME_PERIOD):
            live.update(render(picture, source.setup), refresh=True)


def _json(picture: Picture, source: LiveSource) -> dict[str, Any]:
    return {**picture.as_json(source.setup), "setup": source.setup.as_json()}


def line(picture: Picture) -> str:
    """Return a picture as one line, for logs and pipes."""
    parts = [picture.phase.value, f"step {picture.step}", f"t = {picture.time:.1f} s"]
    error = picture.error_deg(picture.reference)
    if math.isfinite(error):
        parts.append(f"{error:.4g} deg off the reference")
    if picture.torque is not None:
        norm = math.sqrt(float(picture.torque @ picture.torque))
        parts.append(f"|u| {norm:.4g} N m ({source_name(picture.source, 'unknown')})")
    if picture.solve is not None:
        parts.append(f"{picture.solve.status}, {picture.solve.iterations} iterations")
    if picture.decision is not None:
        parts.append(f"alpha {picture.decision.alpha:.3g}")
    if picture.timing is not None:
        parts.append(f"{picture.timing.missed} deadlines missed")
    return ", ".join(parts)


def render(picture: Picture, setup: Setup) -> RenderableType:
    """Return a picture as the dashboard shows it."""
    from rich.panel import Panel
    from rich.table import Table

    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim", justify="right")
    table.add_column()
    for label, value in _rows(picture, setup):
        table.add_row(label, value)
    about = "  ".join(word for word in (setup.method, setup.mode, picture.note) if word)
    step = f"step {picture.step}" + (f" of {setup.n_steps}" if setup.n_steps else "")
    title = f"[{_PHASES[picture.phase]}]{picture.phase.value}[/]  t = {picture.time:.1f} s  {step}"
    return Panel(table, title=title, title_align="left", subtitle=about or None, width=_WIDTH)


def _rows(picture: Picture, setup: Setup) -> Iterator[tuple[str, str | Text]]:
    target = setup.target if picture.target is None else picture.target
    yield "error to target", _number(picture.error_deg(target), ".5g", "deg")
    yield "to reference", _number(picture.error_deg(picture.reference), ".5g", "deg")
    if picture.momentum is not None:
        yield "momentum", "  ".join(f"{v:+.3e}" for v in picture.momentum) + "  N m s"
    for name, margin in picture.margins_deg(setup).items():
        yield f"margin to {name}", _marked(f"{margin:.4g} deg", margin < 0.0)
    yield from _torque_rows(picture, setup)
    if picture.source != Source.METHOD:
        yield from _solver_rows(picture)
    if picture.decision is not None and setup.governor not in ("", "none"):
        decision = picture.decision
        limited = f"  limited by {decision.constraint}" if decision.constraint else ""
        yield "governor alpha", _share(decision.alpha) + limited
    yield from _timing_rows(picture)
    rates = [f"{topic} {rate:.3g}" for topic, rate in picture.rates.items() if rate > 0.0]
    if rates:
        yield "rates [Hz]", "\n".join(", ".join(rates[i : i + 2]) for i in range(0, len(rates), 2))


def _torque_rows(picture: Picture, setup: Setup) -> Iterator[tuple[str, str | Text]]:
    if picture.torque is None:
        return
    norm = math.sqrt(float(picture.torque @ picture.torque))
    scale = setup.torque_limit or max(norm, 1e-12)
    for axis, value in zip("xyz", picture.torque.tolist(), strict=True):
        yield f"torque {axis}", _bar(value, scale, setup.torque_limit)
    limit = f" of {setup.torque_limit:g} N m" if setup.torque_limit else " N m, no limit known"
    yield "|u|", f"{norm:.4e}{limit}"
    yield "from", _source(picture.source)


def _solver_rows(picture: Picture) -> Iterator[tuple[str, str | Text]]:
    solve = picture.solve
    if solve is None:
        return
    yield "solver", _marked(solve.status, solve.status != "converged")
    took = f"{solve.solve_time * 1e6:.0f} us" if math.isfinite(solve.solve_time) else "time unknown"
    if math.isfinite(solve.residual):
        yield "", f"{solve.iterations} iterations, residual {solve.residual:.2e}, {took}"
    if math.isfinite(solve.curvature):
        yield "", f"least curvature {solve.curvature:.3g}"


def _timing_rows(picture: Picture) -> Iterator[tuple[str, str | Text]]:
    timing = picture.timing
    if timing is None:
        return
    yield "timing", _number(timing.speed, ".3g", "times real time")
    if math.isfinite(timing.latency):
        slack = f", slack {timing.slack * 1e3:.1f} ms" if math.isfinite(timing.slack) else ""
        yield "", f"state to torque {timing.latency * 1e3:.2f} ms{slack}"
    unwanted = timing.missed + timing.held + timing.rejected
    counts = f"{timing.missed} deadlines missed, {timing.held} held, {timing.rejected} rejected"
    yield "", _marked(counts, unwanted > 0)


def _bar(value: float, scale: float, limit: float) -> Text:
    """Return a bar to both sides of zero that ends at the limit, which is its frame."""
    from rich.text import Text

    filled = min(round(abs(value) / scale * _BAR), _BAR)
    left = "█" * filled if value < 0.0 else ""
    right = "█" * filled if value > 0.0 else ""
    full = 0.0 < limit <= abs(value) * 1.001
    bar = f"{left:>{_BAR}}│{right:<{_BAR}}"
    return Text.assemble("▕", (bar, "red" if full else "cyan"), f"▏ {value:+.3e} N m")


def _share(value: float) -> str:
    filled = round(max(0.0, min(1.0, value)) * _BAR)
    return f"▕{'█' * filled:<{_BAR}}▏ {value:.4g}"


def _source(source: int) -> Text:
    from rich.text import Text

    colour = _COLOURS[source] if 0 <= source < len(_COLOURS) else "red"
    return Text(source_name(source, "unknown"), style=colour)


def _marked(text: str, unwanted: bool) -> Text:
    from rich.text import Text

    return Text(text, style="red" if unwanted else "green")


def _number(value: float, form: str, unit: str) -> str:
    return f"{value:{form}} {unit}" if math.isfinite(value) else "not known"
