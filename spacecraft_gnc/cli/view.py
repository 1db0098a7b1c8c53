"""``gnc view``: watch a flight in the browser, or in the Foxglove app."""

from __future__ import annotations

import signal
import sys
import time
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spacecraft_gnc.cli._common import JsonOption, QuietOption, UnfinishedOption, print_json
from spacecraft_gnc.cli._domain import (
    AgentOption,
    DomainOption,
    choose_domain,
    find_domain,
    require_namespace,
    tell_choice,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.live.feed import Feed
    from spacecraft_gnc.analysis.live.recorded import RecordedFlight
    from spacecraft_gnc.ros.live_flight import LiveFlight

_HANDOVER = 0.03  # [s] wall for the watchers to take a frame
_LAYOUT = "spacecraft_gnc.foxglove-layout.json"
BagArgument = Annotated[
    Path | None,
    typer.Argument(
        metavar="BAG|FILE.npz",
        help="Bag folder, .mcap file, or .npz of gnc simulate.  [default: the running graph]",
    ),
]
PortOption = Annotated[
    int | None,
    typer.Option(
        "--port",
        metavar="N",
        min=1,
        max=65535,
        help="Port to listen on.  [default: 8760, for Foxglove 8765; taken: any free one]",
    ),
]
HostOption = Annotated[
    str,
    typer.Option(
        "--host",
        metavar="ADDRESS",
        help="Address to listen on; 127.0.0.1 is reached from here only.",
    ),
]
FoxgloveOption = Annotated[
    bool,
    typer.Option(
        "--foxglove",
        help="Serve the Foxglove app instead of a page of our own. Any page open in a browser here "
        "can read this server, for it does not check where a request comes from.",
    ),
]
RateOption = Annotated[
    float, typer.Option("--rate", metavar="X", help="Simulated seconds per second, for a bag.")
]


def view(
    bag: BagArgument = None,
    port: PortOption = None,
    host: HostOption = "127.0.0.1",
    foxglove: FoxgloveOption = False,
    rate: RateOption = 1.0,
    unfinished: UnfinishedOption = False,
    namespace: AgentOption = "",
    domain_id: DomainOption = None,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Do not open the browser.")
    ] = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Watch a flight live at 10 Hz, or a bag with pause and seek; Ctrl-C ends."""
    from spacecraft_gnc.analysis.live.feed import Feed
    from spacecraft_gnc.analysis.live.hosts import is_loopback
    from spacecraft_gnc.analysis.live.server import PageServer

    if not is_loopback(host):
        print(
            f"warning: --host {host}: everybody who reaches this machine can watch; there is no "
            "password",
            file=sys.stderr,
        )
    if bag is None and rate != 1.0:
        raise ParameterError("--rate: received a rate for a live graph; required a bag; name one")
    stop = _StopRequest()
    if foxglove:
        from spacecraft_gnc.cli._view_foxglove import serve_bag, serve_graph
        from spacecraft_gnc.scenario.shipped import shipped_file

        def announce(url: str, port: int) -> None:
            layout = shipped_file(_LAYOUT)
            how = (
                f"in Foxglove: open connection {url}, import layout {layout}; until it ends, any "
                "page open in a browser here can read it too"
            )
            _announce({"url": url, "port": port, "layout": layout}, how, as_json, quiet)

        if bag is None:
            serve_graph(choose_domain(domain_id), host, port, announce, stop)
        else:
            serve_bag(bag, rate, unfinished, host, port, announce, stop)
        return
    with (
        _live(domain_id, namespace)
        if bag is None
        else _recorded(bag, rate, namespace or None, unfinished, quiet or as_json, stop)
    ) as flight:
        feed = Feed(flight)
        with PageServer(feed, host, port) as server:
            about = {"url": server.url, "port": server.port}
            _announce(about, server.url, as_json, quiet)
            if not no_browser and sys.stdout.isatty():
                webbrowser.open(server.url)
            _run(feed, flight, stop)


def _run(feed: Feed, flight: RecordedFlight | LiveFlight, stop: _StopRequest) -> None:
    """Make a frame every tenth of a second, whatever making one takes."""
    from spacecraft_gnc.analysis.live.feed import PERIOD

    due = time.monotonic()
    while not stop():
        feed.tick()
        due = max(due + PERIOD, time.monotonic() + _HANDOVER)  # late: no watcher misses a frame
        flight.wait(due - time.monotonic())


def _live(domain_id: int | None, namespace: str) -> LiveFlight:
    from spacecraft_gnc.ros.live_flight import LiveFlight

    require_namespace(namespace, choose_domain(domain_id))  # refuses where several graphs run
    return LiveFlight(lambda: find_domain(domain_id), namespace, tell_choice)


def _recorded(
    path: Path,
    rate: float,
    namespace: str | None,
    unfinished: bool,
    quiet: bool,
    stop: _StopRequest,
) -> RecordedFlight:
    from spacecraft_gnc.analysis.agents import agents
    from spacecraft_gnc.analysis.live.recorded import RecordedFlight
    from spacecraft_gnc.analysis.reader import load_run
    from spacecraft_gnc.analysis.run_names import run_name

    found = agents(path, namespace, allow_unfinished=unfinished)
    if len(found) > 1:
        tell_choice(str(path), [str(name) for name in found])
    name, *_ = found
    with show_progress("reading", silent=quiet) as progress:

        def tell(done: int, total: int) -> None:
            if stop():  # the signal itself is only remembered
                raise KeyboardInterrupt
            progress(done, total)

        flight = load_run(path, namespace=name, allow_unfinished=unfinished, progress=tell)
    for warning in flight.info.warnings():
        print(f"warning: {warning}", file=sys.stderr)
    title = run_name(path) if name is None else f"{run_name(path)} /{name.strip('/')}"
    return RecordedFlight(flight, title, rate)


def _announce(about: dict[str, Any], text: str, as_json: bool, quiet: bool) -> None:
    if as_json:
        print_json(about)
        sys.stdout.flush()
    elif not quiet:
        print(f"{text}  (Ctrl-C ends)", flush=True)


class _StopRequest:
    """Whether Ctrl-C or SIGTERM asked for the end."""

    def __init__(self) -> None:
        self._asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._ask)

    def _ask(self, *_: Any) -> None:
        self._asked = True

    def __call__(self) -> bool:
        return self._asked
