"""What all nodes of the graph share: life cycle, parameters, endpoints, readiness, refusals."""

from __future__ import annotations

import time
import traceback
from collections import Counter
from collections.abc import Callable
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.nodes._ends import NodeWithEnds
from spacecraft_gnc.nodes._services import guard_services
from spacecraft_gnc.ros.graph_of import members_of
from spacecraft_gnc.ros.parameters import agent_of_namespace, load_graph
from spacecraft_gnc.scenario import Fleet, Scenario
from spacecraft_gnc.signals.graph import DIAGNOSTICS, READY, RECORDER
from spacecraft_gnc.signals.guard import Window
from spacecraft_gnc.signals.message import Stamp, period_ns

_REPORT_PERIOD = 1.0  # [s] wall time between two reports of refused messages
_AT_ONCE = Duration()
_MOST_REPEATS = 40  # of a state that a restarted node waits through for its peers


class GncNode(NodeWithEnds):
    """A lifecycle node around one core.

    Subclasses fill in `build`, `open`, `start` and `stop`. These may raise `GncError`, which
    refuses the transition with its message; what has to be given back they hand to `on_close`.
    """

    fleet: Fleet
    """What flies in the graph."""
    GATHERS: ClassVar[float] = 0.0
    """Wall time for which a process of this node alone lets messages gather while it is active
    [s]; 0: each is handled as it comes."""

    def __init__(self, namespace: str | None = None) -> None:
        super().__init__(self.ROLE, namespace)
        self.configured = self.active = False
        self.finished = False
        """The node has done its work; the runner ends it."""
        self.failure: Exception | None = None
        """Why the last transition was refused, or why the node cannot go on."""
        self.runner_reports = False
        """Whether the runner prints why a transition failed, so that the log need not."""
        self.refusals: Counter[str] = Counter()
        """Messages that were rejected since the node was configured, by topic and kind."""
        self._called = False
        self._asked = 0
        self._last_report = -_REPORT_PERIOD
        guard_services(self)

    # What a node is made of, in the order of its life.

    def build(self, scenario: Scenario) -> None:
        """Make the core and everything that takes long (compiled kernels)."""

    def open(self) -> None:
        """Create publishers, subscriptions and timers, by `advertise`, `listen`, `every`."""

    def start(self) -> None:
        """Begin to work."""

    def stop(self) -> None:
        """Cease to work."""

    def progress(self) -> int:
        """Return a number that changes while messages are handled: it tells when all are."""
        return 0

    def on_everyone_ready(self) -> None:
        """All endpoints of this node are matched, for the first time since activation."""

    def is_unheard(self, step: int) -> bool:
        """Tell, of each repeat of a node's first state, whether the recorder may miss the answer.

        A node restarted in mid-flight finds the recorder before the recorder finds it, by seconds
        on a busy machine, and what it publishes in between is in no bag. The plant repeats the
        state of a stalled step every 0.25 s: the answer waits for a repeat that comes after the
        recorder acknowledged this node's readiness. It has found the endpoints in the order of
        their creation, and that of the readiness is the last one. In the end the node answers all
        the same; the recorder then reports the loss.
        """
        is_lockstep = self.scenario.plant.mode == "lockstep"
        if step == 0 or not is_lockstep or RECORDER not in self.members.names:
            return False
        self._asked += 1
        is_heard = self._called and self._ready.publisher.wait_for_all_acked(_AT_ONCE)
        return not is_heard and self._asked <= _MOST_REPEATS

    # Transitions.

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load parameters, build the core, create the endpoints."""
        return self._attempt(self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start, and announce the node as soon as every endpoint is matched."""
        return self._attempt(self._activate)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop; the endpoints stay."""
        return self._attempt(self._deactivate)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give everything back."""
        return self._attempt(self._cleanup)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop if active, then give everything back."""
        return self._attempt(self._cleanup)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """After a defect of ours: give everything back and become unconfigured."""
        return self._attempt(self._cleanup)

    def _configure(self) -> None:
        try:
            self._build_and_open()
        except BaseException:
            self.close()  # nothing half-made stays
            raise

    def _build_and_open(self) -> None:
        self.fleet = load_graph(self, self.ROLE)
        self.scenario = self.fleet.agents[agent_of_namespace(self.get_namespace(), self.fleet)]
        self.refusals.clear()
        self.window = Window(period_ns(self.scenario.period), self.scenario.n_steps)
        self.members = members_of(self.fleet)
        self.place = self.members.place(self.get_namespace(), self.ROLE)
        self.expect_peers()
        self.build(self.scenario)
        self._diagnostics = self.advertise(DIAGNOSTICS)
        self.keep_time((0, 0), 0)
        self.configured = True
        self.on_close(setattr, self, "configured", False)
        self.open()
        if self.ROLE in READY.publishers:
            self._ready = self.advertise(READY)  # after all others: see `is_unheard`

    def _activate(self) -> None:
        self._called = False
        self._asked = 0
        self.active = True
        try:
            self.start()
        except BaseException:
            self.active = False
            raise
        self._check_ready()

    def _deactivate(self) -> None:
        self.active = False
        self.stop()
        if self.refused:
            self._report_refusals(f"{self.refused} messages rejected")

    def _cleanup(self) -> None:
        if self.active:
            self._deactivate()
        self.await_readers()
        self.close()

    def _attempt(self, transition: Callable[[], None]) -> TransitionCallbackReturn:
        """Run a transition; rclpy itself would swallow the reason of a failure."""
        try:
            transition()
        except GncError as error:
            self.failure = error
            if not self.runner_reports:
                for line in str(error).splitlines():
                    self.get_logger().error(line)
            return TransitionCallbackReturn.FAILURE
        except Exception as error:  # noqa: BLE001 - rclpy would swallow the traceback
            self.failure = error
            self.get_logger().error(traceback.format_exc())
            return TransitionCallbackReturn.ERROR
        return TransitionCallbackReturn.SUCCESS

    # Readiness.

    def on_match(self) -> None:
        """Announce the node once every endpoint is matched."""
        self._check_ready()

    def _check_ready(self) -> None:
        if not self.active or self._called or self.missing():
            return
        self._called = True
        if self.ROLE in READY.publishers:
            self._ready.publish(READY.encode((0, 0), 0, [self.place.node(self.ROLE)]))
        self.on_everyone_ready()

    # Trouble.

    @property
    def refused(self) -> int:
        """Messages that were rejected since the node was configured."""
        return sum(self.refusals.values())

    def refuse(self, topic: object, reason: str, kind: str = "values") -> None:
        """Count a rejected message or request; tell about it once per second at most."""
        self.refusals[f"{topic}/{kind}"] += 1
        now = time.monotonic()
        if now - self._last_report >= _REPORT_PERIOD:
            self._last_report = now
            text = f"{topic}: {reason} (rejected so far: {self.refused})"
            self.get_logger().warning(text)
            if self.configured:
                self._report_refusals(text)

    def _report_refusals(self, text: str) -> None:
        counts = {f"rejected {what}": count for what, count in sorted(self.refusals.items())}
        values = {"rejected_messages": self.refused, **counts}
        self.diagnose(DiagnosticStatus.WARN, text, values)

    def diagnose(
        self, level: bytes, text: str, values: dict[str, Any], stamp: Stamp | None = None
    ) -> None:
        """Publish a diagnostic of this node, of now or of the simulated time ``stamp``."""
        self._diagnostics.publish(self.diagnostic(level, text, values, stamp))

    def diagnostic(
        self, level: bytes, text: str, values: dict[str, Any], stamp: Stamp | None = None
    ) -> bytes:
        """Serialize a diagnostic of this node."""
        entries = [{"key": key, "value": str(value)} for key, value in values.items()]
        status = {
            "level": ord(level),
            "name": self.place.within_graph(self.ROLE),
            "message": text,
            "values": entries,
        }
        if stamp is None:
            now = self.get_clock().now().to_msg()
            stamp = now.sec, now.nanosec
        return DIAGNOSTICS.encode(stamp, 0, [[status]])

    def fail(self, error: Exception) -> None:
        """End the node because of ``error``: the runner reports the first, which causes others."""
        if not self.finished:
            self.failure = error
        self.finished = True
