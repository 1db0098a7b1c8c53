"""Signals: what passes between the parts of a graph, each declared once, without ROS.

A `Signal` is a topic: name, message type, fields with units and rules. From it follow encoding and
decoding, the checks of incoming messages, recording, replay order, export and the type hash.
"""

from spacecraft_gnc.signals.message import Message, Refused
from spacecraft_gnc.signals.rules import ANY, FINITE, INFINITE, ROTATION, Rule
from spacecraft_gnc.signals.signal import Field, Signal

__all__ = [
    "ANY",
    "FINITE",
    "INFINITE",
    "ROTATION",
    "Field",
    "Message",
    "Refused",
    "Rule",
    "Signal",
]
