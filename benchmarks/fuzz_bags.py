"""Damage a small bag in 2,000 seeded ways, and have everything that reads bags read each.

    python benchmarks/fuzz_bags.py [--count 2000] [--first 0] [--cpu 10] [--memory 4]

A reader may give an answer or an error of this package; any other exception, more CPU time than
``--cpu`` seconds for one bag, or more memory than ``--memory`` GiB in all is a failure: it is
printed with its seed, and the exit code is 1. ``test/recording/mutations.py`` does the damage.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "test")]

from flown_bags import fly, sections  # noqa: E402
from recording.mutations import Bases, mutate  # noqa: E402

from spacecraft_gnc.analysis.audit import audit_bag  # noqa: E402
from spacecraft_gnc.analysis.export import read_export  # noqa: E402
from spacecraft_gnc.analysis.metrics import summarize  # noqa: E402
from spacecraft_gnc.analysis.reader import read_flight  # noqa: E402
from spacecraft_gnc.analysis.report import read_run, report_html  # noqa: E402
from spacecraft_gnc.errors import GncError  # noqa: E402
from spacecraft_gnc.recording.bag import open_bag  # noqa: E402
from spacecraft_gnc.recording.playback import Playback  # noqa: E402
from spacecraft_gnc.recording.rebuild import rebuild  # noqa: E402


def _play(path: Path, unfinished: bool) -> None:
    with open_bag(path, allow_unfinished=unfinished) as bag:
        playback = Playback(bag)
        for _ in playback.moments(playback.start_ns):
            pass
        playback.latched(playback.end_ns)


def _summarize(path: Path, unfinished: bool) -> None:
    flight = read_flight(path, allow_unfinished=unfinished)
    summarize(flight.trajectory, flight.info.scenario)


def _rebuild(path: Path, unfinished: bool) -> None:
    if unfinished:
        raise GncError("it takes no such option")
    target = path.parent / "rebuilt"
    rebuild(path, target)
    _summarize(target, False)


def _report(path: Path, unfinished: bool) -> None:
    report_html([read_run(path, "bag", None, allow_unfinished=unfinished)], "")


READERS: dict[str, Callable[[Path, bool], Any]] = {
    "summary": _summarize,
    "audit": lambda path, unfinished: audit_bag(path, allow_unfinished=unfinished),
    "export": lambda path, unfinished: read_export(path, allow_unfinished=unfinished),
    "report": _report,
    "play": _play,
    "recover": _rebuild,
}


class TooLong(BaseException):
    """A bag took more CPU time than it may."""


def _stop(*_: object) -> None:
    raise TooLong


def read(path: Path) -> tuple[str, bool]:
    """Have every reader read a bag; return what went wrong, and whether any of them answered."""
    answered = False
    for name, reader in READERS.items():
        for unfinished in (False, True):
            try:
                reader(path, unfinished)
                answered = True
            except GncError as error:
                if "Traceback" in str(error) or not str(error):
                    return f"{name}: no message: {error!r}", answered
            except (Exception, TooLong):  # noqa: BLE001  # what is looked for
                return f"{name}: {traceback.format_exc()}", answered
    return "", answered


def main() -> int:
    """Damage, read, count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--cpu", type=float, default=10.0, help="[s] for one bag")
    parser.add_argument("--memory", type=float, default=4.0, help="address space [GiB]")
    options = parser.parse_args()
    limit = int(options.memory * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    signal.signal(signal.SIGPROF, _stop)
    failures, done, answers, longest = 0, Counter[str](), 0, 0.0
    with TemporaryDirectory(prefix="gnc_fuzz_") as name:
        folder = Path(name)
        flight = sections(plant={"duration": 2.0}, nmpc_controller={"horizon": 5})
        bases = Bases.of(fly(folder / "flight", flight), folder)
        problem, _ = read(bases.bag)  # compiles, and must be fine
        if problem:
            print(f"the bag that is not damaged: {problem}")
            return 1
        for seed in range(options.first, options.first + options.count):
            kind, path = mutate(bases, seed, folder / "damaged")
            begun = time.process_time()
            signal.setitimer(signal.ITIMER_PROF, options.cpu)
            problem, answered = read(path)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            longest = max(longest, time.process_time() - begun)
            shutil.rmtree(folder / "damaged")
            done[kind] += 1
            answers += answered
            if problem:
                failures += 1
                print(f"seed {seed}, {kind}: {problem}", flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"{sum(done.values())} damaged bags of {len(done)} kinds, {answers} read in part or whole: "
        f"{failures} failures; {longest:.2g} s of CPU at the most, {peak:.2f} GiB"
    )
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
