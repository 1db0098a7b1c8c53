"""Worker thread for computations that would block the executor."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from functools import partial
from queue import SimpleQueue
from threading import Thread
from typing import Any, Generic, TypeVar

from spacecraft_gnc.errors import GncError, LaunchError
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.scenario import Scenario

_PATIENCE = 2.0  # [s] wall time granted to a job at the end; less than a launcher grants a node

Job = TypeVar("Job")
Result = TypeVar("Result")


class Worker(Generic[Job, Result]):
    """Does one job after another in a thread of its own; the executor's thread gets the results.

    All methods belong to the executor's thread. An exception of either function ends the node, as
    it would in a callback.

    Parameters
    ----------
    node : GncNode
        Its executor takes the results.
    compute : callable
        Job to result, called in the worker's thread.
    deliver : callable
        Called with job and result in the executor's thread, unless the worker was closed meanwhile.
    """

    def __init__(
        self,
        node: GncNode,
        compute: Callable[[Job], Result],
        deliver: Callable[[Job, Result], None],
    ) -> None:
        self._node = node
        self._compute = compute
        self._deliver = deliver
        self._jobs: SimpleQueue[Job | None] = SimpleQueue()
        self._closed = False
        self._under_way = 0
        # A daemon, so that a job without end cannot keep the process from ending.
        self._thread = Thread(target=self._work, name=f"{node.ROLE} worker", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether a job is under way, or waits for the one that is."""
        return self._under_way > 0

    def give(self, job: Job) -> None:
        """Begin a job, as soon as those given before have ended."""
        self._under_way += 1
        self._jobs.put(job)

    def require_end(self, work: str) -> None:
        """Refuse an activation while a job of the last one goes on.

        Raises
        ------
        LaunchError
            If the thread still runs.
        """
        if self._thread.is_alive():
            raise LaunchError(
                f"{self._node.ROLE}: received an activation while a {work} of the last one goes "
                "on; required its end; try again later"
            )

    def close(self) -> None:
        """Deliver no more, and wait a little for the thread to end."""
        self._closed = True
        self._jobs.put(None)
        self._thread.join(_PATIENCE)

    # In the worker's thread.

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                outcome = partial(self._deliver_if_open, job, self._compute(job))
            except Exception as error:  # noqa: BLE001 - a thread would swallow it
                outcome = partial(self._fail, error)
            executor = self._node.executor
            if executor is not None:
                # The EventsExecutor knows no guard conditions.
                executor.create_task(self._hand_over, outcome)

    # In the executor's thread.

    def _hand_over(self, outcome: Callable[[], None]) -> None:
        self._under_way -= 1
        try:
            outcome()
        except Exception as error:  # noqa: BLE001 - here it would kill the process: ros2/rclpy#1641
            self._fail(error)

    def _deliver_if_open(self, job: Job, result: Result) -> None:
        if not self._closed:
            self._deliver(job, result)

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, GncError):
            self._node.get_logger().error("".join(traceback.format_exception(error)))
        self._node.fail(error)


def pace_core(core: Any, scenario: Scenario) -> None:
    """Have a controller or governor in free run wait for nothing (`loop.protocols.Controller`)."""
    if scenario.plant.mode == "free_run" and hasattr(core, "waits"):
        core.waits = False
