"""Past of a controller or governor, for the process that takes its place after a death.

What a core remembers (`loop.protocols.Controller`) is kept from time to time, and the inputs of
every step since. A core that was started anew recalls the one and answers the others again: as its
answers follow from memory and inputs alone, its memory is then that of the core that died, to the
last bit. Of a core that does not tell its memory, all steps are answered again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeVar

from spacecraft_gnc.loop.memory_file import Inputs, Kept, MemoryFile
from spacecraft_gnc.loop.plain import pack, unpack

T = TypeVar("T")
_EVERY: Final = 256  # steps of a fast core from one memory to the next


class Past:
    """What one core did, in a file.

    Parameters
    ----------
    core : Controller or Governor
    file : MemoryFile
    again : callable
        Answers a step anew, from its inputs.
    tell : callable
        Takes a sentence on what became of the past, and whether it is a warning.

    Attributes
    ----------
    is_taken_up : bool
        Whether the core went on where another one ended.
    has_news : bool
        Whether that one took a target that it told nobody.
    """

    def __init__(
        self,
        core: Any,
        file: MemoryFile,
        again: Callable[[Inputs], object],
        tell: Callable[[str, bool], object],
    ) -> None:
        self._core, self._file, self._again, self._tell = core, file, again, tell
        self._every = 1 if core.slow else _EVERY
        self._begun = False
        self._forget()

    def begin(self) -> None:
        """Note that the core was reset: what another process left counts the first time only."""
        if self._begun:
            self._file.clear()
        self._begun = True
        self._forget()

    def _forget(self) -> None:
        self._is_known = self.is_taken_up = self.has_news = False
        self._targets: list[Any] = []
        self._last = -1
        self._since = 0
        self._is_kept = True

    def take_up(self, step: int) -> None:
        """Before the first answer: have the core go on before ``step``, where that was left."""
        if self._is_known:
            return
        self._is_known = True
        self._last = step - 1
        found = self._file.find(step)
        if found is not None and self._recall(found):
            self._file.go_on(found)
            self._since = len(found.steps)
            for target in self._targets:
                self._core.set_target(target)
            if self._targets:
                self._keep(self._last, has_news=True)
        else:
            self._file.clear()
            self._keep(self._last, has_news=bool(self._targets), at_start=True)

    def answer(self, step: int, inputs: Inputs, compute: Callable[[], T]) -> T:
        """Return the answer to a step, and keep what a later process needs."""
        if not self._is_known:
            self.take_up(step)
        self._file.note(step, inputs)
        answer = compute()
        self._last = step
        self._since += 1
        if self._since >= self._every and self._is_kept:
            self._keep(step)
        return answer

    def take_target(self, target: Any) -> None:
        """Note that the core took a target."""
        if not self._is_known:
            self._targets.append(target)
        elif not self._keep(self._last, has_news=True):
            self._file.clear()  # of targets the inputs say nothing
            self._is_kept = False

    def _keep(self, step: int, *, has_news: bool = False, at_start: bool = False) -> bool:
        """Keep the core's memory, if it tells it; at the start there is none to tell."""
        tell = getattr(self._core, "memory", None)
        memory = None if tell is None else tell()
        if memory is None and (not at_start or has_news):
            return False
        self._file.keep(step, pack((memory, has_news)))
        self._since = 0
        return True

    def _recall(self, found: Kept) -> bool:
        try:
            memory, has_news = unpack(found.memory)
            if memory is not None:
                self._core.recall(memory)
            for inputs in found.steps:
                self._again(inputs)
        except Exception as error:  # noqa: BLE001 - of whatever kind: it flies on without
            self._core.reset()
            text = f"memory of step {found.step}: {type(error).__name__}: {error}; starting cold"
            self._tell(text, True)
            return False
        self.is_taken_up, self.has_news = True, has_news and not found.steps
        text = f"took up the memory of step {found.step}, and {len(found.steps)} steps since"
        self._tell(text, False)
        return True
