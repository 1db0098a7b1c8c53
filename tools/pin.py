"""Regenerate the reference values of test/pinned: ``python tools/pin.py``.

Regenerate them only in a commit that says why they change: they prove that everything else is
unchanged. ``--check`` writes nothing and compares every scenario with the stored values, bags
included; test/pinned compares all arrays, but the bags of four scenarios only.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "test")]

from pinned import flights, store  # noqa: E402 - found by the line above


def main() -> None:
    """Fly the named scenarios, or all; store the results, or compare them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="SCENARIO", help="[all that are shipped]")
    parser.add_argument("--check", action="store_true", help="compare, write nothing; 1: differs")
    wanted = parser.parse_args()
    unknown = sorted(set(wanted.names) - set(flights.SHIPPED))
    if unknown:
        parser.error(f"received {unknown}; required names of {flights.SHIPPED}")
    differing = [
        line for name in wanted.names or flights.SHIPPED for line in pin(name, check=wanted.check)
    ]
    sys.exit(1 if wanted.check and differing else 0)


def pin(name: str, *, check: bool) -> list[str]:
    """Fly one scenario with and without ROS; return and print differences from stored values."""
    with tempfile.TemporaryDirectory() as folder:
        found = {
            "simulated": flights.simulated(name, Path(folder)),
            "recorded": flights.recorded(name, Path(folder)),
        }
    was = store.load(name) if name in store.names() else found
    lines = [line for kind in found for line in flights.differences(name, was[kind], found[kind])]
    if not check:
        store.save(name, found)
    print("\n".join(lines) or f"{name}: as pinned", flush=True)
    return lines


if __name__ == "__main__":
    main()
