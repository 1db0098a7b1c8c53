"""A launcher looks at the state of a node before it asks for a transition."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node

from spacecraft_gnc.nodes.reference_governor import GovernorNode
from spacecraft_gnc.ros import managed as managed_module
from spacecraft_gnc.ros.managed import Managed, Stage

CONFIGURE, ACTIVATE = 1, 3
_GOAL = {CONFIGURE: "inactive", ACTIVATE: "active"}
_START = {CONFIGURE: "unconfigured", ACTIVATE: "inactive"}


class Fake(Node):
    """Answers as a lifecycle node, and notes what it was asked for in which state.

    The first requests may be answered by lies: with success, though nothing is done.
    """

    def __init__(self, label: str = "unconfigured", lies: int = 0, name: str = "some") -> None:
        super().__init__(name)
        self.label = label
        self.asked: list[tuple[int, str]] = []
        self._lies = lies
        self.create_service(GetState, "/fake/get_state", self._tell)
        self.service = self.create_service(ChangeState, "/fake/change_state", self._change)

    def _tell(self, _: Any, answer: Any) -> Any:
        answer.current_state.label = self.label
        return answer

    def _change(self, request: Any, answer: Any) -> Any:
        wanted = request.transition.id
        self.asked.append((wanted, self.label))
        answer.success = len(self.asked) <= self._lies or self.label == _START[wanted]
        if len(self.asked) > self._lies and answer.success:
            self.label = _GOAL[wanted]
        return answer


@pytest.fixture
def managed(ros: Any) -> Managed:
    return Managed(ros.add(Node("launcher")), "fake")


def brought(ros: Any, managed: Managed, to: Sequence[Stage] = (Stage.ACTIVE,)) -> None:
    """Push a node until it has come so far."""

    def push() -> bool:
        managed.push(may_activate=True)
        return managed.stage in to

    ros.spin_until(push)


def test_a_node_is_configured_and_activated(ros: Any) -> None:
    governor = ros.add(GovernorNode())
    managed = Managed(ros.add(Node("launcher")), "reference_governor")
    brought(ros, managed)
    assert governor.active


@pytest.mark.parametrize(
    ("label", "asked"),
    [
        ("unconfigured", [(CONFIGURE, "unconfigured"), (ACTIVATE, "inactive")]),
        ("inactive", [(ACTIVATE, "inactive")]),
        ("active", []),
    ],
)
def test_it_is_asked_for_what_is_missing(
    ros: Any, managed: Managed, label: str, asked: list[tuple[int, str]]
) -> None:
    fake = ros.add(Fake(label))
    brought(ros, managed)
    assert fake.asked == asked


def test_who_was_not_configured_after_all_is_asked_again(ros: Any, managed: Managed) -> None:
    """As if a node that a killed launcher left behind had answered for it."""
    fake = ros.add(Fake(lies=1))
    brought(ros, managed)
    assert fake.asked == [(CONFIGURE, "unconfigured")] * 2 + [(ACTIVATE, "inactive")]


def test_a_refusal_is_one(ros: Any, managed: Managed) -> None:
    fake = ros.add(Fake())
    brought(ros, managed, [Stage.CONFIGURED])
    fake.label = "errorprocessing"
    managed._ask(Stage.ACTIVATING)
    brought(ros, managed, [Stage.REFUSED])
    assert fake.asked == [(CONFIGURE, "unconfigured"), (ACTIVATE, "errorprocessing")]


def test_while_two_answer_to_a_name_nothing_is_asked(ros: Any, managed: Managed) -> None:
    other, fake = ros.add(Fake("active", name="other")), ros.add(Fake())
    ros.spin_until(lambda: managed._node.count_services("/fake/change_state") == 2)
    brought(ros, managed, [Stage.CONFIGURING])
    for _ in range(2):
        answer = managed._look
        ros.spin_until(answer.done)
        managed.push(may_activate=True)
        assert managed.stage is Stage.CONFIGURING
        managed._look_at_state()  # as after a second
    assert not other.asked + fake.asked
    other.destroy_service(other.service)
    ros.executor.remove_node(other)
    brought(ros, managed)
    assert fake.asked == [(CONFIGURE, "unconfigured"), (ACTIVATE, "inactive")]


def test_a_stranger_who_answers_to_the_name_does_not_hold_up_the_start(
    ros: Any, managed: Managed, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(managed_module, "_PATIENCE", 0.01)
    for name in ("one", "other"):
        ros.add(Fake(name=name))
    ros.spin_until(lambda: managed._node.count_services("/fake/change_state") == 2)
    brought(ros, managed)
