"""Workers of dask.distributed: a cluster of this machine's own, or any scheduler's."""

from __future__ import annotations

import logging
import os
import signal
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from typing import Any, Final

from spacecraft_gnc import SILENT_COMPILER
from spacecraft_gnc.errors import LaunchError, ParameterError
from spacecraft_gnc.extras import explained_imports

_CONNECTING: Final = 5.0  # wall time until a scheduler has to answer [s]
_GATHERING: Final = 10.0  # wall time until it has to have a worker [s]
_CLOSING: Final = 5.0  # wall time until workers have to be gone [s]
_LIBRARIES: Final = ("asyncio", "distributed", "tornado")  # whose loggers are silenced
_LEAN: Final = {
    "distributed.worker.profile.enabled": False,  # else it samples the stack 100 times a second
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.low-level-log-length": 100,
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.work-stealing": False,
}
"""Settings of a cluster of our own; each only costs time and memory where blocks are alike."""
_ONE_THREAD: Final = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)


@contextmanager
def connected(workers: int | None = None, scheduler: str | None = None) -> Iterator[Any]:
    """Yield a `distributed.Client` with workers, and close what was started for it.

    Parameters
    ----------
    workers
        Processes to start on this machine; by default one for each core.
    scheduler
        Address of a scheduler to use instead, such as ``tcp://127.0.0.1:8786``.

    Raises
    ------
    ParameterError
        If the scheduler cannot be reached, or has no worker.
    """
    with explained_imports():
        import distributed  # noqa: F401 - told in one line where it is missing
    _silence()
    with _of_scheduler(scheduler) if scheduler is not None else _local(workers) as client:
        yield client


@contextmanager
def _local(workers: int | None) -> Iterator[Any]:
    import dask
    from distributed import Client, LocalCluster

    with tempfile.TemporaryDirectory(prefix="gnc-campaign-") as folder:
        environment = {"distributed.nanny.pre-spawn-environ": {SILENT_COMPILER: "1", **_ONE_THREAD}}
        with dask.config.set({"temporary-directory": folder, **environment, **_LEAN}):
            with _interrupt_blocked():
                cluster = LocalCluster(
                    n_workers=workers or len(os.sched_getaffinity(0)),
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address="127.0.0.1:0",
                    scheduler_kwargs={"dashboard": False},
                    memory_limit=0,
                    silence_logs=logging.CRITICAL,
                )
                client = Client(cluster)
            try:
                yield client
            except BaseException:
                _kill_workers(cluster)  # rather than wait for the flights that they are at
                raise
            finally:
                client.close(_CLOSING)
                with suppress(TimeoutError):  # on a busy machine; they end with this process
                    cluster.close(_CLOSING)


def _kill_workers(cluster: Any) -> None:
    for nanny in list(cluster.workers.values()):
        nanny.auto_restart = False
        if nanny.pid:
            os.kill(nanny.pid, signal.SIGKILL)


@contextmanager
def _of_scheduler(address: str) -> Iterator[Any]:
    from distributed import Client

    class Closed(Client):  # type: ignore[misc]  # skipped by mypy
        def __del__(self) -> None:
            """Do nothing: one that never came to be would complain in trying to close."""

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of versions: those that matter each worker checks
            client = Closed(address, timeout=_CONNECTING, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise ParameterError(
            f"--scheduler: received {address!r}, which does not answer within {_CONNECTING:g} s; "
            "required the address of a dask scheduler, such as tcp://127.0.0.1:8786; start one "
            "with `dask scheduler`"
        ) from error
    try:
        try:
            client.wait_for_workers(1, timeout=_GATHERING)
        except TimeoutError as error:
            raise ParameterError(
                f"--scheduler: received {address!r}, which has no worker within {_GATHERING:g} s; "
                f"required at least one; start it with `dask worker {address} --nthreads 1`"
            ) from error
        yield client
    finally:
        client.close(_CLOSING)


class SchedulerLost(LaunchError):
    """The scheduler, or every worker of it, is gone."""


@contextmanager
def _interrupt_blocked() -> Iterator[None]:
    """Keep Ctrl-C from threads and processes that are started here; they inherit the mask.

    It is for the main thread alone, which ends the workers in order.
    """
    resource_tracker.ensure_running()  # for it unblocks the signal where it is started
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _silence() -> None:
    """Keep the words of the libraries to themselves: what matters is told by this package."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in _LIBRARIES:
            logging.getLogger(name).setLevel(logging.CRITICAL)
