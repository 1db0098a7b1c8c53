"""Send 1,000 seeded random service calls to a graph in flight, and compare what it flew.

    python benchmarks/hostile_services.py [--calls 1000] [--seed 1] [--duration 4000]

A stranger in the domain of the flight calls everything that a node serves: parameters of unknown
types, of NaN, of huge lists and of names that nobody has; transitions; SlewTo goals with NaN, 100
goals or cancels at once, results of goals that nobody sent; requests cut off after their header.
Targets that make sense are those of the scenario, so that the flight stays the same: its torques
are those of `gnc simulate`, bit for bit. Exit code 1: a call without an answer, a flight that did
not end well, or a torque that differs. Of a storm only the last call has to be answered: the queue
of a service holds ten.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from hostile_calls import Stranger  # noqa: E402

from spacecraft_gnc.analysis.reader import read_flight  # noqa: E402
from spacecraft_gnc.errors import GncError  # noqa: E402
from spacecraft_gnc.launcher.launcher import Launcher  # noqa: E402
from spacecraft_gnc.launcher.plan import make_plan  # noqa: E402
from spacecraft_gnc.launcher.progress import Display, Report  # noqa: E402
from spacecraft_gnc.scenario import load_fleet  # noqa: E402

SCENARIO = ROOT / "config" / "gupta2015_case1.yaml"  # its target is the identity


class Attack(Display):
    """Has a stranger attack a launch once it flies.

    Parameters
    ----------
    calls, seed
        Of the stranger.
    """

    def __init__(self, calls: int, seed: int) -> None:
        self.launcher: Launcher | None = None
        self.stranger: Stranger | None = None
        self._calls, self._seed = calls, seed
        self._thread: threading.Thread | None = None
        self.took = math.nan

    def starting(self, stages: object) -> None:
        """Enter the domain: to discover what nodes serve takes a while."""
        if self.stranger is None and self.launcher is not None:
            self.stranger = Stranger(self.launcher._domain_id, self._seed)  # noqa: SLF001

    def flying(self, report: Report) -> None:
        """Begin as soon as it flies."""
        if report.step >= 0:
            self.begin()

    def begin(self) -> None:
        """Begin, once."""
        if self._thread is None and self.stranger is not None:
            self._thread = threading.Thread(target=self._attack)
            self._thread.start()

    def _attack(self) -> None:
        began = time.monotonic()
        assert self.stranger is not None  # noqa: S101
        self.stranger.attack(self._calls)
        self.took = time.monotonic() - began

    def close(self) -> None:
        """End it, as the flight has."""
        if self.stranger is None:
            return
        self.stranger.stops = True
        if self._thread is not None:
            self._thread.join()
        self.stranger.close()


def attacked(out: Path, calls: int, seed: int, changes: Sequence[str] = ()) -> Attack:
    """Fly Case I under attack; return the attack.

    Raises
    ------
    GncError
        If the flight did not end well.
    """
    attack = Attack(calls, seed)
    attack.launcher = Launcher(make_plan(SCENARIO, changes, out=out), attack, time.monotonic())
    attack.launcher.run()
    return attack


def differing(bag: Path, changes: Sequence[str]) -> int:
    """Return how many torques of a bag are not those of the simulation, to the last bit."""
    flown = read_flight(bag).trajectory.torque
    (loop,) = load_fleet(SCENARIO, changes).build().values()
    simulated = loop.run().torque
    if flown.shape != simulated.shape:
        return max(len(flown), len(simulated))
    return int((flown != simulated).any(axis=1).sum())


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--calls", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--duration", type=float, default=4000.0, help="of the flight [s]")
    options = parser.parse_args()
    changes = (f"plant.duration={options.duration}", "plant.command_timeout=60.0")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        try:
            attack = attacked(out, options.calls, options.seed, changes)
        except GncError as error:
            print(f"the flight did not end well: {error}")
            return 1
        wrong = differing(out / "bag", changes)
    stranger = attack.stranger
    assert stranger is not None  # noqa: S101 - it flew
    for kind, count in sorted(stranger.sent.items()):
        print(f"{kind:28} {count:5} sent")
    print(
        f"{sum(stranger.sent.values())} calls in {attack.took:.1f} s: {stranger.unanswered} "
        f"without an answer, {stranger.accepted} goals accepted; {wrong} torques differ from the "
        "simulation"
    )
    too_few = sum(stranger.sent.values()) < options.calls
    if too_few:
        print("the flight was over before that: give a longer --duration")
    return int(bool(stranger.unanswered or wrong or too_few))


if __name__ == "__main__":
    raise SystemExit(main())
