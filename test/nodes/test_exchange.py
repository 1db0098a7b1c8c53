"""Messages between nodes of one process: order, listeners from outside, and what is counted."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.nodes._exchange import HANDED_OVER, Exchange
from spacecraft_gnc.nodes._losses import SequenceWatch


class Topic:
    """A topic with readers in this process, and what DDS is told of it."""

    def __init__(self, exchange: Exchange, name: str, readers: int, heard: list[bytes]) -> None:
        self.published: list[bytes] = []
        self.matched = readers
        self.send = exchange.outlet(name, self.published.append, lambda: self.matched)
        self.open = ExitStack()
        for _ in range(readers):
            self.open.enter_context(exchange.reading(name, heard.append))


@pytest.fixture
def heard() -> list[bytes]:
    return []


@pytest.fixture
def exchange() -> Exchange:
    return Exchange()


@pytest.fixture
def topic(exchange: Exchange, heard: list[bytes]) -> Callable[..., Topic]:
    return lambda name="/a", readers=2: Topic(exchange, name, readers, heard)


def deliver_all(exchange: Exchange) -> None:
    while exchange.deliver():
        pass
    assert not exchange


def test_topics_are_heard_in_the_order_of_publication(
    exchange: Exchange, topic: Callable[..., Topic], heard: list[bytes]
) -> None:
    a, b = topic("/a"), topic("/b", readers=1)
    for send, data in ((a.send, b"1"), (b.send, b"2"), (a.send, b"3")):
        send(data)
    assert heard == []  # no callback within another one
    assert exchange
    deliver_all(exchange)
    assert heard == [b"1", b"1", b"2", b"3", b"3"]
    assert a.published == b.published == []


def test_what_a_reader_answers_comes_after_what_waits(exchange: Exchange) -> None:
    heard: list[bytes] = []
    answer = exchange.outlet("/answer", heard.append, lambda: 1)
    ask = exchange.outlet("/ask", heard.append, lambda: 2)

    def reply(data: bytes) -> None:
        heard.append(data)
        answer(b"answer to " + data)

    with (
        exchange.reading("/ask", reply),
        exchange.reading("/ask", heard.append),
        exchange.reading("/answer", heard.append),
    ):
        ask(b"1")
        deliver_all(exchange)
    assert heard == [b"1", b"1", b"answer to 1"]


def test_a_listener_from_outside_makes_the_topic_public_for_good(
    exchange: Exchange, topic: Callable[..., Topic], heard: list[bytes]
) -> None:
    a, b = topic("/a"), topic("/b")
    a.matched += 1
    a.send(b"1")
    a.matched -= 1  # what is still on its way over DDS must not be overtaken
    a.send(b"2")
    b.send(b"3")
    deliver_all(exchange)
    assert a.published == [b"1", b"2"]
    assert heard == [b"3", b"3"]


def test_what_waits_is_not_overtaken_by_dds(
    exchange: Exchange, topic: Callable[..., Topic], heard: list[bytes]
) -> None:
    a = topic()
    a.send(b"1")
    exchange.deliver()
    a.matched += 1
    a.send(b"2")
    assert a.published == []
    deliver_all(exchange)
    a.send(b"3")
    assert a.published == [b"3"]
    assert heard == [b"1", b"1", b"2", b"2"]


def test_readers_that_dds_has_yet_to_match_are_reached_over_dds(
    exchange: Exchange, topic: Callable[..., Topic], heard: list[bytes]
) -> None:
    a = topic()
    a.matched = 1
    a.send(b"1")
    a.matched = 2
    a.send(b"2")
    deliver_all(exchange)
    assert a.published == [b"1"]
    assert heard == [b"2", b"2"]


def test_without_readers_nothing_is_published(
    exchange: Exchange, topic: Callable[..., Topic], heard: list[bytes]
) -> None:
    a = topic()
    a.open.close()
    a.matched = 0
    a.send(b"1")
    deliver_all(exchange)
    assert heard == a.published == []


@given(events=st.lists(st.sampled_from(["send", "deliver", "join", "leave"]), max_size=60))
def test_every_message_is_heard_once_and_in_order(events: list[str]) -> None:
    """Whoever joins or leaves: DDS, which delivers once nothing waits here, never overtakes."""
    exchange, heard = Exchange(), []
    a = Topic(exchange, "/a", 1, heard)
    sent = 0
    for event in events:
        if event == "send":
            sent += 1
            a.send(b"%d" % sent)
        elif event == "deliver":
            exchange.deliver()
        else:
            a.matched = 2 if event == "join" else 1
        if a.published and not exchange:
            heard += a.published
            a.published.clear()
    deliver_all(exchange)
    assert heard + a.published == [b"%d" % n for n in range(1, sent + 1)]


def test_what_is_handed_over_is_no_loss() -> None:
    watch = SequenceWatch()
    numbers = [HANDED_OVER, *({"publication_sequence_number": n} for n in (1, 2)), HANDED_OVER]
    assert not any(watch.see(info) for info in numbers)
    assert watch.see({"publication_sequence_number": 4})
    assert watch.lost == 1
