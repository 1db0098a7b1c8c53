"""Attack flights on loopback, and break the machine under them; print what came of it.

    .venv/bin/python benchmarks/hostile.py [--only NAME ...] [--short] [--markdown]

Every experiment starts `gnc launch`, as a user does, and attacks it from other processes: hostile
messages, commands of a stranger, service calls, dead and stopped nodes, a full disk, long flights.
What is random is seeded; every wait has an end, and so has every process. The exit code is 1 if one
of them fails. `docs/reliability.md` holds the table; the tests run the short form.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from hostile_faults import kills, stops
from hostile_flight import Row
from hostile_long import guards, repeat, soak
from hostile_wire import messages, steering

SIZES: Final[dict[str, tuple[float, float, str]]] = {
    "messages": (50_000, 600, "hostile messages of each flight"),
    "rate": (2_000, 400, "of these [1/s]"),
    "steering": (2_000, 400, "of each of four kinds"),
    "calls": (1_000, 60, "of services"),
    "kills": (10, 1, "of each node in each mode"),
    "recorder_kills": (20, 0, "of the recorder alone"),
    "stop": (5.0, 1.0, "of a node [s]"),
    "steps": (300_000, 3_000, "of a long flight"),
    "rounds": (5, 1, "of flights with and without seals"),
    "round_steps": (5_000, 500, "of each of these"),
    "runs": (20, 1, "of test/graph"),
    "factor": (8.0, 8.0, "times real time, in free run"),
}
"""Default, short form, meaning of each size."""


def services(options: argparse.Namespace) -> list[Row]:
    """Call services that nobody asked for: `hostile_services.py`, a program of its own."""
    script = Path(__file__).with_name("hostile_services.py")
    sizes = ["--calls", str(int(options.calls)), "--seed", str(options.seed)]
    done = subprocess.run(
        [sys.executable, str(script), *sizes],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    lines = (done.stdout if done.returncode in (0, 1) else done.stderr).strip().splitlines()
    return [
        Row(
            "service calls",
            "random requests for parameters, transitions and slews, in bursts and cut off",
            int(options.calls),
            "every call answered; the flight equals `gnc simulate`, or ends by name",
            lines[-1] if lines else f"exit code {done.returncode}",
            done.returncode == 0,
        )
    ]


EXPERIMENTS: Final[dict[str, Callable[[argparse.Namespace], Iterable[Row]]]] = {
    "messages": messages,
    "steering": steering,
    "services": services,
    "kills": kills,
    "stops": stops,
    "soak": soak,
    "guards": guards,
    "repeat": repeat,
}
LONG: Final = ("repeat",)
"""Only where asked for."""
SHORT: Final = ("messages", "steering", "kills")
"""In the short form; short calls of services are tested in `test/graph`."""


def main() -> int:
    """Run the experiments; return 1 if one fails."""
    options = _options()
    rows: list[Row] = []
    for name in options.only:
        begun = time.monotonic()
        with TemporaryDirectory(prefix=f"gnc_hostile_{name}_") as folder:
            options.folder = Path(folder)
            for row in EXPERIMENTS[name](options):
                rows.append(row)
                print(_line(row), flush=True, file=sys.stderr if options.markdown else sys.stdout)
        print(f"  {name}: {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
    if options.markdown:
        print(_markdown(rows))
    return int(any(row.passed is False for row in rows))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append", choices=EXPERIMENTS, metavar="NAME")
    parser.add_argument("--short", action="store_true", help="small sizes, as the tests use them")
    parser.add_argument("--markdown", action="store_true", help="print a table")
    parser.add_argument("--seed", type=int, default=1)
    for name, (full, short, meaning) in SIZES.items():
        text = f"{meaning} [{full:g}; short: {short:g}]"
        parser.add_argument(f"--{name.replace('_', '-')}", type=type(full), help=text)
    options = parser.parse_args()
    for name, (full, short, _) in SIZES.items():
        if getattr(options, name) is None:
            setattr(options, name, short if options.short else full)
    usual = SHORT if options.short else [name for name in EXPERIMENTS if name not in LONG]
    options.only = options.only or list(usual)
    return options


_WORDS: Final = {True: "passed", False: "FAILED", None: "left out"}


def _line(row: Row) -> str:
    return f"{_WORDS[row.passed]:<8} {row.name:<28} {row.number:>7}  {row.measured}"


def _markdown(rows: list[Row]) -> str:
    lines = ["| experiment | what is done | how many | required | measured | |", "|---" * 6 + "|"]
    for row in rows:
        cells = (row.name, row.done, f"{row.number:,}", row.required, row.measured)
        lines.append(
            "| " + " | ".join(c.replace("|", "/") for c in cells) + f" | {_WORDS[row.passed]} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
