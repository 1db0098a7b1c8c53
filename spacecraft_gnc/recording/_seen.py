"""Repeated steps of a topic: a repeated step must carry the same message."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from spacecraft_gnc.errors import RecordingError


@dataclass(slots=True)
class Seen:
    """Steps of one topic, with a digest of each message.

    Attributes
    ----------
    where
        Bag and topic, for messages.
    unique
        Whether another message of a step means another run in the bag.
    """

    where: str
    unique: bool
    digests: dict[int, int] = field(default_factory=dict)
    latest: int = -1

    def conflicts(self, steps: Sequence[int], messages: Sequence[bytes]) -> tuple[int, ...]:
        """Take note of messages; return the steps that had come before with other content.

        Raises
        ------
        RecordingError
            If they show that the bag holds two runs.
        """
        different = []
        for step, data in zip(steps, messages, strict=True):
            digest = hash(data)
            known = self.digests.get(step)
            if known is None:
                self.digests[step] = digest
                self.latest = max(self.latest, step)
            elif known != digest:
                self._require_one_run(f"two different messages of step {step}")
                different.append(step)
            elif step < self.latest - 1:  # what is sent again comes at once
                self._require_one_run(f"step {step} again after step {self.latest}")
        return tuple(different)

    def _require_one_run(self, found: str) -> None:
        if self.unique:
            raise RecordingError(
                f"{self.where} holds {found}; required one run of one spacecraft; record each run "
                "into a bag of its own"
            )
