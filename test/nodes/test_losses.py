"""Messages that never came are counted, by the numbers DDS gives them."""

from __future__ import annotations

import random
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from spacecraft_gnc.nodes._losses import SequenceWatch, with_info


def watch_of(publishers: int) -> SequenceWatch:
    watch = SequenceWatch()
    watch.on_match(SimpleNamespace(total_count=publishers))
    return watch


def see(watch: SequenceWatch, numbers: Any) -> list[int]:
    """Return the numbers before which something was lost."""
    return [n for n in numbers if watch.see({"publication_sequence_number": n})]


@given(dropped=st.sets(st.integers(2, 99)), first=st.integers(1, 50))
def test_every_gap_of_one_publisher_is_counted(dropped: set[int], first: int) -> None:
    watch = watch_of(1)
    arrived = [n for n in range(first, 101) if n == first or n not in dropped]
    told = see(watch, arrived)
    assert watch.lost == 101 - first - len(arrived)  # what was sent before the match does not count
    assert told == [n for n in arrived if n > first and n - 1 not in arrived]


@given(seed=st.integers(0, 2**32), count=st.integers(2, 4))
def test_no_loss_is_invented_for_several_publishers(seed: int, count: int) -> None:
    chance = random.Random(seed)
    turns = [publisher for publisher in range(count) for _ in range(chance.randrange(30))]
    chance.shuffle(turns)
    last = [0] * count
    watch = watch_of(count)
    for publisher in turns:
        last[publisher] += 1
        see(watch, [last[publisher]])
    assert watch.lost == 0


def test_a_gap_among_publishers_that_have_all_been_heard() -> None:
    watch = watch_of(2)
    assert see(watch, [1, 1, 2, 2, 5, 3]) == [5]
    assert watch.lost == 2


def test_a_publisher_that_came_anew_or_joined_late_lost_nothing() -> None:
    watch = watch_of(1)
    see(watch, [7, 8, 9, 1, 2, 3])  # the second begins anew
    watch.on_match(SimpleNamespace(total_count=3))
    see(watch, [500, 501, 4])
    assert watch.lost == 0


def test_an_rmw_that_does_not_number_is_no_loss() -> None:
    watch = watch_of(1)
    assert see(watch, [None, None]) == []
    assert watch.lost == 0


@pytest.mark.parametrize("executor_type", [EventsExecutor, SingleThreadedExecutor])
def test_message_info_comes_under_every_executor(ros: Any, executor_type: Any) -> None:
    node = ros.add(Node("both"))
    ros.executor.remove_node(node)
    executor = executor_type()
    executor.add_node(node)
    taken: list[Any] = []
    callback = with_info(lambda data, info: taken.append((data, info)))
    node.create_subscription(String, "word", callback, 10, raw=True)
    publisher = node.create_publisher(String, "word", 10)
    ros.executor.remove_node(node)
    while publisher.get_subscription_count() < 1:
        executor.spin_once(timeout_sec=0.05)
    sent = serialize_message(String(data="a"))
    publisher.publish(sent)
    publisher.publish(sent)
    while len(taken) < 2:
        executor.spin_once(timeout_sec=0.05)
    executor.remove_node(node)
    assert [data for data, _ in taken] == [sent, sent]
    assert [info["publication_sequence_number"] for _, info in taken] == [1, 2]
