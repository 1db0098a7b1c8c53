"""The terminal dashboard of ``gnc inspect watch``."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup
from spacecraft_gnc.cli._common import RunFailed
from spacecraft_gnc.cli._inspect_messages import print_json_line
from spacecraft_gnc.drawing.live import Panel

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
_MOODS: Final = {"": "", "warn": "yellow", "bad": "red"}
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
                    print(line(picture, source.setup), flush=True)


def _first_picture(view: GraphView, source: LiveSource, patience: float) -> Picture | None:
    """Return the first picture with a state; None after Ctrl-C."""

    def is_heard() -> bool:
        source.look()
        return source.heard

    view.spin_until(is_heard, patience)
    if source.heard or view.interrupted:
        return source.picture() if source.heard else None
    raise RunFailed(f"{source.picture().note}; required a flight; wait longer with --timeout")


def _whole_picture(view: GraphView, source: LiveSource) -> Picture:
    """Return a picture once parameters and rates are known, or after some patience."""

    def is_whole() -> bool:
        picture = source.picture()
        return bool(source.setup.period > 0.0 and picture.rates and source.is_answered)

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
    return {**picture.as_json(), "setup": source.setup.as_json()}


def line(picture: Picture, setup: Setup) -> str:
    """Return a picture as one line, for logs and pipes."""
    parts = [picture.phase.value, f"step {picture.step}", f"t = {picture.time:.1f} s"]
    if setup.vehicle is not None and picture.values:
        parts += setup.vehicle.line(picture.values)
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
    panels = () if setup.vehicle is None else setup.vehicle.panels(setup.scenario)
    for panel in panels:
        if panel.kind == "bars":
            yield from _bars(panel, picture)
    for readouts in picture.readouts(setup).values():
        for label, text, mood in readouts:
            yield label, _styled(text, _MOODS[mood])
    rates = [f"{topic} {rate:.3g}" for topic, rate in picture.rates.items() if rate > 0.0]
    if rates:
        yield "rates [Hz]", "\n".join(", ".join(rates[i : i + 2]) for i in range(0, len(rates), 2))


def _bars(panel: Panel, picture: Picture) -> Iterator[tuple[str, str | Text]]:
    (series,) = panel.series
    value = picture.values.get(series.key)
    if value is None:
        return
    norm = math.sqrt(float(value @ value))
    scale = panel.limit or max(norm, 1e-12)
    for i, number in enumerate(value.tolist()):
        name = series.names[i] if series.names else f"{panel.numbered}{i + 1}"
        yield f"{panel.name} {name}", _bar(number, scale, panel)
    limit = f" of {panel.limit:g} {panel.unit}" if panel.limit else f" {panel.unit}, no limit known"
    if panel.norm:
        yield panel.norm, f"{norm:.4e}{limit}"


def _bar(value: float, scale: float, panel: Panel) -> Text:
    """Return a bar to both sides of zero that ends at the limit, which is its frame."""
    filled = min(round(abs(value) / scale * _BAR), _BAR)
    left = "█" * filled if value < 0.0 else ""
    right = "█" * filled if value > 0.0 else ""
    full = 0.0 < panel.limit <= abs(value) * 1.001
    bar = _styled(f"{left:>{_BAR}}│{right:<{_BAR}}", "red" if full else "cyan")
    return _styled("▕", "") + bar + _styled(f"▏ {value:+.3e} {panel.unit}", "")


def _styled(text: str, style: str) -> Text:
    from rich.text import Text

    return Text(text, style=style)
