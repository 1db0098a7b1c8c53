"""Serialized messages of a rigid spacecraft, and the rclpy arguments of its signals."""

from __future__ import annotations

from typing import Any, Final

from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.vehicles.rigid_body.signals import STATE, TORQUE, StateAndRate

PERIOD_NS: Final = 400_000_000
"""Control period of Case I [ns]."""


def tell(node, topic, data) -> None:
    """Hand a message to what a node has subscribed to a topic, guard and all."""
    (end,) = (one for one in node.subscriptions if one.topic_name == f"/{topic}")
    end.callback(data)


def encode_state(stamp, state, rate) -> bytes:
    return STATE.encode(stamp, state.step, StateAndRate(state, rate))


def encode_reference(stamp, step, reference) -> bytes:
    return REFERENCE.encode(stamp, step, reference)


def decode_reference(data):
    """Return step and reference."""
    message = REFERENCE.decode(data)
    return message.step, REFERENCE.value(message)


def torque_step(data) -> int:
    return TORQUE.decode(data).step


def ends(signal: Signal) -> tuple[Any, str, Any]:
    """Return message class, name and profile as rclpy arguments."""
    from spacecraft_gnc.ros.endpoints import message_type
    from spacecraft_gnc.ros.qos import ros_qos

    return message_type(signal.type), signal.name, ros_qos(signal.qos)
