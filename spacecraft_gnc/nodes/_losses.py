"""Loss detection by the sequence numbers of DDS."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Final

NUMBER: Final = "publication_sequence_number"
"""Key of the number in a message info of rclpy; its value is None where nobody counts."""
_PAIR = inspect.signature(lambda data, info: None)  # noqa: ARG005 - only its shape is of use


class SequenceWatch:
    """Counts the losses of one subscription.

    DDS numbers the messages of each publisher 1, 2, 3, ...; rclpy hands over the number but not the
    publisher. A message therefore belongs to the publisher whose turn its number is. Of one
    publisher every gap is counted. Of several the count is a lower bound: a publisher that has not
    been heard yet may have begun with the number at hand.

    The message-lost event of DDS is no help: it is silent when a reader's queue overflows, and
    under the EventsExecutor (rclpy 7.1, Fast DDS 2.14) taking it can block for ever on a lock that
    DDS holds while it waits for Python.

    Parameters
    ----------
    alone
        Whether one publisher at a time is heard, whoever else is matched.
    """

    def __init__(self, *, alone: bool = False) -> None:
        self._alone = alone
        self._expected: list[int] = []  # next number of each publisher heard so far
        self._publishers = 0  # that have ever been matched
        self.lost = 0
        """Messages lost so far."""

    def see(self, info: Mapping[str, Any]) -> bool:
        """Take the message info of one message; return whether messages before it were lost."""
        number = info[NUMBER]
        expected = self._expected
        if number in expected:  # nearly always; a handful of publishers at most
            expected[expected.index(number)] = number + 1
            return False
        return number is not None and self._begins_or_skips(number)  # None: the RMW does not count

    def _begins_or_skips(self, number: int) -> bool:
        behind = [candidate for candidate in self._expected if candidate < number]
        if not behind or len(self._expected) < self._publishers:
            # A publisher that had sent before it was matched: those messages were not for us.
            self._expected.append(number + 1)
            return False
        nearest = max(behind)
        self._expected[self._expected.index(nearest)] = number + 1
        self.lost += number - nearest
        return True

    def on_match(self, event: Any) -> None:
        """Take a matched event of the subscription."""
        if not self._alone:
            self._publishers = max(self._publishers, event.total_count)

    def before(self, callback: Callable[[Any], None]) -> Callable[[Any], None]:
        """Return a callback for matched events that takes them first."""

        def on_match(event: Any) -> None:
            self.on_match(event)
            callback(event)

        return on_match


class Unwatched(SequenceWatch):
    """Counts no loss: of what comes by the user's door.

    Whoever sends there numbers as he likes, and what he sends is no message of the flight.
    """

    def see(self, info: Mapping[str, Any]) -> bool:
        """Take the message info of one message; nothing was lost before it."""
        return False


def with_info(callback: Callable[[bytes, Mapping[str, Any]], None]) -> Callable[..., None]:
    """Return a subscription callback that gets message info under every executor.

    rclpy looks at the signature to learn whether a callback wants the info; its EventsExecutor
    (7.1) then passes message and info as one tuple, its other executors as two arguments.
    """

    def on_message(*taken: Any) -> None:
        data, info = taken if len(taken) == 2 else taken[0]
        callback(data, info)

    on_message.__signature__ = _PAIR  # type: ignore[attr-defined]
    return on_message
