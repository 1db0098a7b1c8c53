"""Node ``reference_governor``: answers each state with the reference to track."""

from __future__ import annotations

import math
from typing import ClassVar

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import State
from spacecraft_gnc.nodes import _convert as convert
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes._slew_server import SlewServer
from spacecraft_gnc.nodes._status import GovernorStatusEncoder
from spacecraft_gnc.nodes._topics import GOVERNOR, GOVERNOR_STATUS, REFERENCE, STATE, TARGET
from spacecraft_gnc.scenario import Scenario

_NEVER = -1


class GovernorNode(GncNode):
    """Publishes reference k on state k; takes targets by topic and by the SlewTo action."""

    ROLE: ClassVar[str] = GOVERNOR

    def build(self, scenario: Scenario) -> None:
        """Build the governor and load its kernels."""
        self._governor = scenario.build_governor()
        self._governor.warm_up()
        self._status = GovernorStatusEncoder()
        self._step = _NEVER

    def open(self) -> None:
        """Create the endpoints."""
        self._publish_reference = self.advertise(REFERENCE).publish
        self._publish_status = self.advertise(GOVERNOR_STATUS).publish
        self.listen(STATE, self._on_state)
        self.listen(TARGET, self._on_target)
        parameters = self.scenario.governor
        self._slews = SlewServer(
            self,
            self._governor.set_target,
            math.radians(parameters.slew_tolerance_deg),
            parameters.slew_rate_tolerance,
        )
        self.on_close(self._slews.destroy)

    def start(self) -> None:
        """Return to the scenario's target."""
        self._governor.reset()
        self._step = _NEVER
        self._state_bytes = self._reference_bytes = b""

    def stop(self) -> None:
        """Let go of the slew being flown."""
        self._slews.preempt("the governor was stopped")

    def progress(self) -> int:
        """Step answered last."""
        return self._step

    def _on_state(self, data: bytes) -> None:
        if not self.active:
            return
        if data == self._state_bytes:
            self._publish_reference(self._reference_bytes)
            return
        try:
            stamp, state, rate = convert.decode_state(data, self._step)
        except convert.Refused as error:
            self.refuse(STATE, str(error))
            return
        self._step = state.step
        self._state_bytes = data
        alpha = self._answer(stamp, state)
        self._slews.update(state, rate, alpha)

    def _answer(self, stamp: convert.Stamp, state: State) -> float:
        decision = self._governor.decide(state)
        self._reference_bytes = convert.encode_reference(stamp, state.step, decision.reference)
        self._publish_reference(self._reference_bytes)
        self._publish_status(self._status.encode(stamp, state.step, decision))
        return decision.alpha

    def _on_target(self, data: bytes) -> None:
        if not self.active:
            return
        try:
            _, target = convert.decode_reference(data)
            self._governor.set_target(target.attitude)
        except (convert.Refused, GncError) as error:
            self.refuse(TARGET, str(error))
            return
        self._slews.preempt(f"replaced by a target on the topic {TARGET.name}")


def main() -> int:
    """Run the node until it is told to end."""
    return run(GovernorNode)


if __name__ == "__main__":
    raise SystemExit(main())
