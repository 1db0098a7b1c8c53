"""Execution of a launch plan: start, configure, activate, monitor and stop the nodes."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher import domain, environment
from spacecraft_gnc.launcher.deadlines import lateness
from spacecraft_gnc.launcher.memories import Memories
from spacecraft_gnc.launcher.outcome import Interrupted, NodeDied, NodeRefused, Outcome
from spacecraft_gnc.launcher.plan import COMPOSED, PLANT, RECORDER, LaunchPlan, node_options
from spacecraft_gnc.launcher.process import NodeProcess, end_all
from spacecraft_gnc.launcher.progress import Display
from spacecraft_gnc.signals.members import role_of, space_of
from spacecraft_gnc.signals.seal import key_in, new_key

if TYPE_CHECKING:  # rclpy is imported while the nodes start
    from spacecraft_gnc.ros.strangers import Stranger
    from spacecraft_gnc.ros.supervisor import Supervisor

_BEAT: Final = 0.05  # [s] wall: longest delay in noticing a death or a signal
_STARTUP_PATIENCE: Final = 120.0  # [s] wall until step 0, including compilation of kernels
_END_PATIENCE: Final = 5.0  # [s] wall for a node to end
_DRAIN_PATIENCE: Final = 30.0  # [s] wall for the recorder to drain its queues
_MOST_RESTARTS: Final = 3  # per node


class Launcher:
    """Launches one plan, once.

    Parameters
    ----------
    plan : LaunchPlan
    display : Display
        Shows the progress.
    born : float
        ``time.monotonic()`` at the start of the user's command [s].
    """

    def __init__(self, plan: LaunchPlan, display: Display, born: float) -> None:
        self.plan = plan
        self.display = display
        self._born = born
        given = key_in(os.environ)  # whoever set one starts nodes by hand that are to take part
        self._key = new_key() if given is None else given
        self._processes: dict[str, NodeProcess] = {}
        self._restarts: list[str] = []
        self._memories = Memories(plan.restart)
        self._bags = [plan.bag] if plan.records else []
        self._startup_time = math.nan
        self._signal = 0
        self._has_logs = True
        self._strangers: list[Stranger] = []
        self._warned = False

    def run(self) -> Outcome:
        """Fly the scenario and return the outcome.

        Raises
        ------
        DomainTaken
            If another graph runs on the requested domain.
        NodeRefused
            If a node could not be configured.
        NodeDied
            If a node ended unexpectedly; all others were stopped and the bag closed.
        Interrupted
            If the user ended the launch; all nodes were stopped and the bag closed.
        """
        try:
            lock = self._claim_domain()
        except LaunchError:
            self.plan.discard()
            raise
        try:
            self._domain_id = lock.domain_id
            self._environment = environment.for_node(os.environ, lock.domain_id, self._key)
            with suppress(OSError):  # a full disk: the first log tells
                self.plan.logs.mkdir(exist_ok=True)
            with self._signals():
                supervisor = self._fly()
        finally:
            self._memories.close()
            lock.release()
        progress = supervisor.progress
        return Outcome(
            domain_id=lock.domain_id,
            steps=self.plan.scenario.n_steps,
            simulated_time=self.plan.scenario.n_steps * self.plan.scenario.period,
            wall_time=progress.wall_elapsed,
            startup_time=self._startup_time,
            missed_deadlines=progress.missed_deadlines,
            restarts=tuple(self._restarts),
            bags=tuple(str(bag) for bag in self._bags),
            strangers=tuple(map(str, self._strangers)),
            refused=supervisor.refused,
        )

    def _claim_domain(self) -> domain.DomainLock:
        about = {"scenario": str(self.plan.scenario.path), "out": str(self.plan.out.resolve())}
        if "" not in self.plan.fleet.agents:
            about["agents"] = " ".join(self.plan.fleet.agents)
        if self.plan.fleet.craft:
            about["craft"] = " ".join(self.plan.fleet.craft)
        given = self.plan.scenario.launcher.domain_id
        if given < 0 and os.environ.get(environment.DOMAIN_ID):
            given = environment.domain_id(os.environ)
        return domain.claim_given(given, about) if given >= 0 else domain.claim_free(about)

    def _fly(self) -> Supervisor:
        """Start, monitor and stop the processes; return what has looked after them."""
        try:
            for name in [COMPOSED] if self.plan.composed else self.plan.nodes:
                self._start(name, autostart=False)
            from spacecraft_gnc.ros.supervisor import Supervisor

            plan = self.plan
            with Supervisor(plan.nodes, plan.fleet, self._domain_id, self._key) as supervisor:
                self.display.waiting(self.plan, self._domain_id)
                self._bring_up(supervisor)
                while not self._finished():
                    self._watch(supervisor)
                    self.display.flying(supervisor.progress)
                    self._warn(supervisor.progress)
                self._tell_strangers(supervisor.strangers_now())
                supervisor.spin(0.0)
                self._warn(supervisor.progress, over=True)
                self._end()
                supervisor.spin(_BEAT)  # the nodes' last words
                self._tell_strangers(supervisor.strangers_gone())
                self._require_good_ends()
                return supervisor
        finally:
            self._end()
            self.display.close()

    def _start(self, name: str, *, autostart: bool) -> None:
        module = "composed" if name == COMPOSED else role_of(name)
        arguments = ["-m", f"spacecraft_gnc.nodes.{module}"]
        arguments += self.plan.nodes if name == COMPOSED else []
        arguments += ["--ros-args", "--params-file", str(self.plan.parameter_file)]
        bag = self._bags[-1] if self._bags else self.plan.bag
        for option in node_options(autostart, bag.resolve()):
            arguments += ["-p", option]
        if space_of(name):
            arguments += ["-r", f"__ns:=/{space_of(name)}"]
        log = self.plan.logs / f"{name.replace('/', '.')}.log"
        environment, inherited = self._memories.of(name, self._environment)
        self._processes[name] = NodeProcess(name, arguments, environment, log, inherited)

    def _bring_up(self, supervisor: Supervisor) -> None:
        """Wait until the first step has started."""
        deadline = time.monotonic() + _STARTUP_PATIENCE
        while supervisor.progress.step < 0 and not self._finished():
            self._watch(supervisor)
            stages = {name: stage.value for name, stage in supervisor.stages().items()}
            self.display.starting(stages)
            refused = [name for name, stage in stages.items() if stage == "refused"]
            if refused:
                raise self._refusal(refused)
            if time.monotonic() > deadline:
                raise self._overdue(stages)
        elapsed = supervisor.progress.wall_elapsed
        self._startup_time = time.monotonic() - self._born - elapsed

    def _watch(self, supervisor: Supervisor) -> None:
        """Wait one polling period; check for signals and dead nodes."""
        supervisor.spin(_BEAT)
        self._look_at_logs()
        self._tell_strangers(supervisor.strangers)
        if self._signal:
            raise Interrupted(self._signal)
        for name, process in list(self._processes.items()):
            if process.exit_code is not None and not self._finished():
                self._on_death(name, process, supervisor)

    def _tell_strangers(self, strangers: Sequence[Stranger]) -> None:
        """Report those who are none of the flight's nodes, each once."""
        for stranger in strangers:
            if stranger not in self._strangers:
                self._strangers.append(stranger)
                self.display.tell(
                    f"error: {stranger}: received what comes from none of this flight's nodes; "
                    "required them alone; end it, or fly on another launcher.domain_id"
                )

    def _look_at_logs(self) -> None:
        """Say once if a log cannot be written."""
        for process in self._processes.values():
            if process.log_trouble and self._has_logs:
                self._has_logs = False
                text = f"{process.log}: {process.log_trouble}; the logs of this flight have gaps"
                self.display.tell(f"warning: {text}")

    def _warn(self, progress: Any, *, over: bool = False) -> None:
        """Warn once if the controller does not keep up."""
        elapsed = math.inf if over else progress.wall_elapsed
        text = lateness(progress.missed_deadlines, progress.step, elapsed, self.plan.scenario)
        if text and not self._warned:
            self._warned = True
            self.display.warn(text)

    def _finished(self) -> bool:
        """Whether the plant has completed the scenario."""
        host = self._processes[COMPOSED if self.plan.composed else PLANT]
        return host.exit_code == 0

    def _on_death(self, name: str, process: NodeProcess, supervisor: Supervisor) -> None:
        step = supervisor.progress.step
        restarts = self._restarts.count(name)
        if not self.plan.restart or name == PLANT or step < 0 or restarts >= _MOST_RESTARTS:
            raise self._death(process, step)
        process.join(0.0)
        self.display.note(f"{process.describe_end()}; starting it again")
        self._restarts.append(name)
        if name == RECORDER:
            self._bags.append(self.plan.out / f"bag-{len(self._bags) + 1}")
        supervisor.admit(name)
        self._start(name, autostart=True)

    def _end(self) -> None:
        """Stop the remaining nodes: publishers before the recorder."""
        first = [name for name in self._processes if name != RECORDER]
        end_all([self._processes[name] for name in first], _END_PATIENCE)
        if RECORDER in self._processes:
            end_all([self._processes[RECORDER]], _DRAIN_PATIENCE)
        self._look_at_logs()

    def _require_good_ends(self) -> None:
        for process in self._processes.values():
            if process.exit_code != 0:
                raise self._death(process, self.plan.scenario.n_steps)

    def _death(self, process: NodeProcess, step: int) -> LaunchError:
        """Name a node that ended at once, before the others are ended; return the error."""
        time_reached = f" at step {step}" if step >= 0 else " before step 0"
        reasons = process.errors()
        if reasons and step < 0:
            return NodeRefused("\n".join(f"{process.name}: {reason}" for reason in reasons))
        reason = f": {last}" if (last := process.last_error()) else ""
        text = f"{process.describe_end()}{time_reached}{reason}; its log: {process.log}"
        self.display.tell(f"error: {text}")
        return NodeDied(text, process.last_output(), told=True)

    def _refusal(self, names: Sequence[str]) -> NodeRefused:
        self._end()  # the nodes print their reasons as they end
        hosts = [self._processes.get(name) or self._processes[COMPOSED] for name in names]
        lines = [f"{host.name}: {reason}" for host in hosts for reason in host.errors()]
        return NodeRefused("\n".join(lines) or f"{', '.join(names)}: refused; see {self.plan.logs}")

    def _overdue(self, stages: dict[str, str]) -> LaunchError:
        state = ", ".join(f"{name} {stage}" for name, stage in stages.items())
        host = self._processes.get(PLANT) or self._processes[COMPOSED]
        return NodeDied(
            f"no step within {_STARTUP_PATIENCE:g} s ({state}); required nodes that find each "
            f"other; read the logs in {self.plan.logs}",
            host.last_output(),
        )

    @contextmanager
    def _signals(self) -> Iterator[None]:
        """Turn SIGINT and SIGTERM into an orderly shutdown."""
        numbers = (signal.SIGINT, signal.SIGTERM)
        before = {number: signal.getsignal(number) for number in numbers}

        def remember(number: int, _: Any) -> None:
            self._signal = number

        for number in numbers:
            signal.signal(number, remember)
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
