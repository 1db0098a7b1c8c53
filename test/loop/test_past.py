"""Past of a core: what another one takes up of it, and when it begins cold."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from spacecraft_gnc.loop.memory_file import Inputs, MemoryFile
from spacecraft_gnc.loop.past import Past


@pytest.fixture
def descriptor() -> Iterator[int]:
    file = os.memfd_create("core")
    yield file
    os.close(file)


class Silent:
    """A core that counts, by ones or as it was asked, and does not tell its memory."""

    slow = False

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        self.count, self.stride = 0, 1

    def set_target(self, target: int) -> None:
        self.stride = target

    def step(self) -> int:
        self.count += self.stride
        return self.count


class Counter(Silent):
    """The same, which tells it."""

    def memory(self) -> tuple[int, ...]:
        return self.count, self.stride

    def recall(self, memory: tuple[int, ...]) -> None:
        self.count, self.stride = memory


NOTHING: Inputs = (b"state", b"")


def past_of(core: Silent, descriptor: int) -> tuple[Past, list[tuple[str, bool]]]:
    told: list[tuple[str, bool]] = []
    file = MemoryFile(descriptor)
    past = Past(core, file, lambda _: core.step(), lambda *tale: told.append(tale))
    past.begin()
    return past, told


@pytest.mark.parametrize("kind", [Counter, Silent])
def test_steps_since_the_memory_are_answered_again(kind: type[Silent], descriptor: int) -> None:
    core = kind()
    past, told = past_of(core, descriptor)
    for k in range(600):
        past.answer(k, NOTHING, core.step)
    core = kind()
    past, told = past_of(core, descriptor)
    assert past.answer(600, NOTHING, core.step) == 601
    step, since = (511, 88) if kind is Counter else (-1, 600)
    assert told == [(f"took up the memory of step {step}, and {since} steps since", False)]
    core = kind()  # a step that was answered is answered again
    past, _ = past_of(core, descriptor)
    assert past.answer(600, NOTHING, core.step) == 601


def test_a_target_counts_at_once_and_is_news_until_it_was_told(
    descriptor: int,
) -> None:
    core = Counter()
    past, _ = past_of(core, descriptor)
    past.answer(0, NOTHING, core.step)
    core.set_target(10)
    past.take_target(10)
    for _ in range(2):  # the second one ended after the answer
        core = Counter()
        past, _ = past_of(core, descriptor)
        past.take_up(1)
        assert past.is_taken_up
        assert past.has_news
        assert past.answer(1, NOTHING, core.step) == 11
    core = Counter()
    past, _ = past_of(core, descriptor)
    assert past.answer(2, NOTHING, core.step) == 21
    assert not past.has_news


def test_after_a_target_a_core_that_does_not_tell_its_memory_starts_cold(
    descriptor: int,
) -> None:
    core = Silent()
    past, _ = past_of(core, descriptor)
    past.answer(0, NOTHING, core.step)
    past.take_target(10)
    past.answer(1, NOTHING, core.step)
    core = Silent()
    past, told = past_of(core, descriptor)
    assert past.answer(2, NOTHING, core.step) == 1
    assert not past.is_taken_up
    assert not told


def test_a_memory_that_does_not_fit_is_told_and_left(descriptor: int) -> None:
    core = Counter()
    past, _ = past_of(core, descriptor)
    past.answer(0, NOTHING, core.step)
    core.memory = lambda: (1, 2, 3)  # type: ignore[method-assign]
    past.take_target(1)
    core = Counter()
    past, told = past_of(core, descriptor)
    assert past.answer(1, NOTHING, core.step) == 1
    assert told[0][0].startswith("memory of step 0: ValueError")
    assert told[0][1]


def test_an_activation_after_the_first_one_forgets(descriptor: int) -> None:
    core = Counter()
    past, _ = past_of(core, descriptor)
    for k in range(10):
        past.answer(k, NOTHING, core.step)
    core.reset()
    past.begin()
    assert past.answer(10, NOTHING, core.step) == 1
    core = Counter()
    past, _ = past_of(core, descriptor)
    assert past.answer(11, NOTHING, core.step) == 2
