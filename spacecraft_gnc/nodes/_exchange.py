"""Messages between nodes of one process, handed over in memory while nobody else listens.

A message that only nodes of its own process hear needs no DDS, and no seal: nobody else can have
sent it. The order is that of publication, over all topics. As soon as DDS has matched a listener
from another process with a topic, the topic is public: from then on its messages go over DDS,
sealed, to everybody, as in a graph of several processes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

from spacecraft_gnc.nodes._losses import NUMBER

Send = Callable[[bytes], None]
HANDED_OVER: Final[dict[str, Any]] = {NUMBER: None}
"""Message info of what did not come over DDS, which therefore did not count it."""


class _Line:
    """One topic within the process."""

    __slots__ = ("is_public", "readers", "waiting")

    def __init__(self) -> None:
        self.readers: list[Send] = []
        self.waiting = 0
        """Messages that were sent and not delivered, one for each reader."""
        self.is_public = False


class Exchange:
    """Hands messages over between the nodes of a process, from one thread."""

    def __init__(self) -> None:
        self._lines: dict[str, _Line] = {}
        self._queue: deque[tuple[_Line, Send, bytes]] = deque()

    def __bool__(self) -> bool:
        """Whether messages wait to be delivered."""
        return bool(self._queue)

    def outlet(self, topic: str, publish: Send, count: Callable[[], int]) -> Send:
        """Return what sends the messages of a topic.

        Parameters
        ----------
        topic
            Full name.
        publish
            Sends a message over DDS.
        count
            Returns how many subscriptions DDS has matched, those of this process included.
        """
        line, queue = self._line(topic), self._queue

        def send(data: bytes) -> None:
            readers = line.readers
            if not line.is_public:
                surplus = count() - len(readers)
                # What waits must not be overtaken; fewer: this process has yet to find itself.
                if surplus == 0 or (surplus > 0 and line.waiting):
                    line.waiting += len(readers)
                    for receive in readers:
                        queue.append((line, receive, data))
                    return
                line.is_public = surplus > 0
            publish(data)

        return send

    @contextmanager
    def reading(self, topic: str, receive: Send) -> Iterator[None]:
        """Deliver the messages of a topic, named in full, to ``receive`` too."""
        readers = self._line(topic).readers
        readers.append(receive)
        try:
            yield
        finally:
            readers.remove(receive)

    def deliver(self) -> bool:
        """Deliver the message that waits longest to one reader; return whether there was one."""
        if not self._queue:
            return False
        line, receive, data = self._queue.popleft()
        line.waiting -= 1
        receive(data)
        return True

    def _line(self, topic: str) -> _Line:
        return self._lines.setdefault(topic, _Line())
