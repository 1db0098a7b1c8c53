"""Blocks of runs, flown by the workers of a cluster in any order."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from queue import Empty, SimpleQueue
from typing import Any, Final, NamedTuple

from spacecraft_gnc.campaign.cluster import SchedulerLost
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.errors import GncError, ParameterError

_BLOCK: Final = 1.0  # wall time of a block [s]
_GROWTH: Final = 4  # of a block over the one before, until its time is known well
_LARGEST: Final = 2_000  # runs of a block
_AHEAD: Final = 3  # blocks for each thread of a worker that are sent out
_COUNTING: Final = 5.0  # wall time between two counts of the workers [s]
_PATIENCE: Final = 60.0  # wall time without any worker [s]

Task = Callable[[Spec, int, int], Any]
"""Called by a worker with the campaign, the first run and the number of runs."""


class Block(NamedTuple):
    """Consecutive runs that were flown together."""

    runs: range
    result: Any
    """What the task returned, not None; None of a run that ended every worker it was given to."""


class Engine:
    """Sends blocks of runs to workers and yields them as they come back.

    A block whose worker dies is flown again by another one. One that dies with worker after worker
    is halved, and a run that does is flown alone in the end, so that the one to blame is found.

    Parameters
    ----------
    client : distributed.Client
        See `cluster.connected`.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._back: SimpleQueue[Any] = SimpleQueue()
        self._threads, self._counted, self._seen = 1, -_COUNTING, time.monotonic()

    def map(
        self, task: Task, spec: Spec, runs: Iterable[range], size: BlockSize | None = None
    ) -> Iterator[Block]:
        """Yield the runs in blocks, each with what ``task`` returns, in any order.

        Raises
        ------
        GncError
            That a task raises: a worker of other versions.
        SchedulerLost
            If nobody is left to fly.
        """
        size, left, suspects = size or BlockSize(1), list(runs)[::-1], list[range]()
        pending: dict[Any, tuple[Any, range]] = {}
        submit = self._submitter(task, spec, pending)
        try:
            while left or pending or suspects:
                while left and len(pending) < _AHEAD * self.threads():
                    submit(_taken(left, size.next(sum(map(len, left)), self._threads)))
                alone = not pending
                if alone:  # so that no other run can be to blame
                    submit(suspects.pop())
                block, result = self._back_from(pending)
                if result is not None or alone:
                    yield Block(block, result)
                elif len(block) == 1:
                    suspects.append(block)
                else:
                    middle = len(block) // 2
                    left += [block[middle:], block[:middle]]
        finally:
            if pending:
                self._client.cancel([future for future, _ in pending.values()])

    def _submitter(
        self, task: Task, spec: Spec, pending: dict[Any, tuple[Any, range]]
    ) -> Callable[[range], None]:
        numbers, token = count(), uuid.uuid4().hex[:8]

        def submit(block: range) -> None:
            key = (f"fly-{token}", next(numbers))
            future = self._client.submit(task, spec, block.start, len(block), key=key, pure=False)
            pending[key] = future, block
            future.add_done_callback(self._back.put)

        return submit

    def _back_from(self, pending: dict[Any, tuple[Any, range]]) -> tuple[range, Any]:
        """Return the next block that is back, and its result; None: its workers died."""
        while True:
            future = self._next()
            if future.key in pending:  # not of a map that was given up
                return pending.pop(future.key)[1], _result(future)

    def threads(self) -> int:
        """Return how many flights can be flown at once."""
        now = time.monotonic()
        if now - self._counted >= _COUNTING:
            self._counted, found = now, sum(self._client.nthreads().values())
            self._threads = max(found, 1)
            self._seen = now if found else self._seen
        return self._threads

    def _next(self) -> Any:
        """Return the next future that is done."""
        while True:
            try:
                return self._back.get(timeout=1.0)
            except Empty:
                self._require_workers()

    def _require_workers(self) -> None:
        if self._client.status != "running":
            raise SchedulerLost(_lost("the connection to the scheduler", "is lost"))
        self.threads()
        if time.monotonic() - self._seen > _PATIENCE:
            raise SchedulerLost(_lost("the scheduler", f"has had no worker for {_PATIENCE:g} s"))


class BlockSize:
    """Size of the next block, by the time that runs have taken.

    Parameters
    ----------
    largest
        Runs of a block at most.
    """

    def __init__(self, largest: int = _LARGEST) -> None:
        self._largest = largest
        self._last = 0
        self._seconds: float | None = None

    def learn(self, seconds: float) -> None:
        """Take the wall time of a run [s]; later ones count more."""
        known = self._seconds
        self._seconds = seconds if known is None else 0.7 * known + 0.3 * seconds

    def next(self, left: int, threads: int) -> int:
        """Return the size of the next block, of ``left`` runs for ``threads``."""
        wanted = 1 if self._seconds is None else round(_BLOCK / max(self._seconds, 1e-9))
        share = -(-left // (2 * threads))  # so that all end at about the same time
        bounds = (wanted, share, self._largest, _GROWTH * max(self._last, 1))
        self._last = max(1, min(bounds))
        return self._last


def _taken(left: list[range], size: int) -> range:
    """Take the next block off the end of what is left."""
    runs = left.pop()
    if len(runs) > size:
        left.append(runs[size:])
    return runs[:size]


def _result(future: Any) -> Any:
    """Return what a task returned; None if one worker after the other died of it."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        return None
    except GncError:
        raise
    except CancelledError as error:
        raise SchedulerLost(_lost("the scheduler", "has given up what it was asked for")) from error
    except (ImportError, AttributeError) as error:
        raise ParameterError(
            f"worker: received {error}; required this version of spacecraft_gnc with its extra "
            "'campaign' on every worker; install it there"
        ) from error


def _lost(what: str, happened: str) -> str:
    return (
        f"{what} {happened}; required one with workers until the campaign is complete; start it "
        "again, and the same command goes on where it stopped"
    )
