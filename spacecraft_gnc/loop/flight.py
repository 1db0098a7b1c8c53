"""The record of one closed-loop flight: one array for each column that its vehicle declares."""

from __future__ import annotations

import dataclasses
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from typing_extensions import Self

from spacecraft_gnc.arguments import require_path
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.types import Array

_COLUMN_KEY: Final = "spacecraft_gnc.column"
_SCENARIO: Final = "scenario"
_DEFAULTS: Final = "scenario_defaults"
_SHARED: Final = ("period", "time")
_SUFFIX: Final = ".npy"
_ITEM: Final = 8  # bytes of a number
UNREADABLE: Final = (
    OSError, KeyError, ValueError, EOFError, RuntimeError, MemoryError, zipfile.BadZipFile,
    zlib.error, tokenize.TokenError,
)  # fmt: skip
"""What reading a ``.npz`` file may raise: it is missing, torn or another kind of file, or a header
in it is damaged, which asks for any size."""


@dataclasses.dataclass(slots=True)
class Step:
    """One control step as the loop flies it."""

    state: Any
    """At the start of the step."""
    target: Any
    """What the governor is asked for."""
    decision: Any
    """The governor's, with the reference."""
    command: Any
    """`loop.protocols.Command`"""
    applied: Any = None
    """What the plant's actuators give of its control."""


class End(NamedTuple):
    """What is known at the end of the last step."""

    state: Any
    reference: Any
    """Of the last step; at this time, where it moves by itself."""


class Moment(Enum):
    """When the value of a column is read, and of what."""

    START = "start"
    """Before the plant makes a step: of a `Step`."""
    OUTCOME = "outcome"
    """After it: of the plant, which tells what happened over the step."""
    END = "end"
    """Once, after the last step: of the `End`."""


class Column(NamedTuple):
    """What a flight keeps of each step, or of its end."""

    read: str | Callable[[Any], Any]
    """Dotted attribute, or what returns the value; None where there is none."""
    shape: tuple[int, ...]
    """-1: a length that the first value tells."""
    missing: float | int
    """Where there is no value; an integer makes the column one of integers, a bool one of bools."""
    signal: str
    """Topic of the message that carries the value."""
    member: str
    """Dotted field of that message."""
    moment: Moment = Moment.START
    of: Callable[[Any], Any] | None = None
    """What returns the object to read of instead of the step itself; None where there is none."""
    formerly: float | None = None
    """Its value in files written before the column existed; None: it was always there."""

    @property
    def at_end(self) -> bool:
        """Whether it has one value, that of the end of the last step."""
        return self.moment is Moment.END

    @property
    def type(self) -> type:
        """NumPy type of a number."""
        if isinstance(self.missing, bool):
            return np.bool_
        return np.int64 if isinstance(self.missing, int) else np.float64


def column(
    read: str | Callable[[Any], Any],
    shape: tuple[int, ...] = (),
    *,
    carried_by: str = "",
    missing: float = np.nan,
    moment: Moment = Moment.START,
    of: Callable[[Any], Any] | None = None,
    formerly: float | None = None,
) -> Any:
    """Return a field of a `Flight`: an array (n, *shape), row k of control step k.

    ``carried_by``: ``"topic/field"`` of the message in which a recording has the value. A dotted
    attribute is read faster than by a function; columns with the same ``of`` share its call.
    """
    return _field(
        Column(read, shape, missing, *_topic_and_member(carried_by), moment, of, formerly)
    )


def final(
    read: str | Callable[[End], Any], shape: tuple[int, ...] = (), *, carried_by: str = ""
) -> Any:
    """Return a field of a `Flight`: an array of ``shape`` at the end of the last step."""
    return _field(Column(read, shape, np.nan, *_topic_and_member(carried_by), Moment.END))


def _topic_and_member(carried_by: str) -> tuple[str, str]:
    topic, _, member = carried_by.partition("/")
    return topic, member


def _field(made: Column) -> Any:
    return dataclasses.field(metadata={_COLUMN_KEY: made})


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """Arrays of a flight; a vehicle's own class adds a `column` for each.

    Attributes
    ----------
    period : float
        Control period [s].
    time : (n,) array
        Start of each step [s].
    """

    period: float
    time: Array

    if TYPE_CHECKING:  # whoever knows no vehicle reads columns by name

        def __getattr__(self, name: str) -> Any: ...

    @property
    def n_steps(self) -> int:
        """Number of control steps."""
        return len(self.time)

    @classmethod
    def columns(cls) -> Iterator[tuple[str, Column]]:
        """Yield (name, column) of what a flight keeps beside the time."""
        for field in dataclasses.fields(cls):
            if _COLUMN_KEY in field.metadata:
                yield field.name, field.metadata[_COLUMN_KEY]

    @classmethod
    def bytes_per_step(cls) -> int:
        """Return the memory that one step takes [bytes]."""
        rows = (column.shape for _, column in cls.columns() if not column.at_end)
        return _ITEM * (1 + sum(abs(int(np.prod(shape))) for shape in rows))

    def save(self, path: str | Path, scenario: str = "", defaults: str = "") -> Path:
        """Write all arrays to a ``.npz`` file, whole or not at all.

        Parameters
        ----------
        path
            File to write.
        scenario
            Text of what flew, kept beside the arrays as ``scenario``; empty: not known.
        defaults
            Text of the defaults that it took (`Scenario.stated_defaults`), likewise.

        Raises
        ------
        RecordingError
            If the file cannot be written.
        """
        return save_flights(path, {"": self}, scenario, defaults)

    @classmethod
    def load(cls, path: str | Path, agent: str = "") -> Self:
        """Read a file written by `save` of this class, or one ``agent`` of `save_flights`.

        Raises
        ------
        RecordingError
            If it is missing, damaged or not such a file.
        """
        stored = {item.name: _stored(agent, item.name) for item in dataclasses.fields(cls)}
        later = {name: column for name, column in cls.columns() if column.formerly is not None}
        optional = {stored[name] for name in later}
        found = _read(require_path("path", path), *stored.values(), optional=optional)
        values = {name: found[key] for name, key in stored.items() if key in found}
        values["period"] = float(values["period"])
        for name, column in later.items():
            if name not in values:
                values[name] = np.full((len(values["time"]), *column.shape), column.formerly)
        return cls(**values)

    @staticmethod
    def load_scenario(path: str | Path) -> str:
        """Read the scenario in a file written by `save`; empty where it holds none."""
        return str(_read(path, _SCENARIO).get(_SCENARIO, ""))

    @staticmethod
    def load_defaults(path: str | Path) -> str:
        """Read the defaults in a file written by `save`; empty where it holds none."""
        return str(_read(path, _DEFAULTS).get(_DEFAULTS, ""))


def save_flights(
    path: str | Path, flights: Mapping[str, Flight], scenario: str = "", defaults: str = ""
) -> Path:
    """Write the flights of agents to one file, each array under its agent: ``sc1.attitude``.

    Period and time, which all share, are written once; the only flight of an agent without a name
    is written under plain names. Arguments and errors are those of `Flight.save`.
    """
    target = Path(require_path("path", path))
    arrays = {
        _stored(agent, item.name): getattr(flight, item.name)
        for agent, flight in flights.items()
        for item in dataclasses.fields(flight)
    }
    for name, text in ((_SCENARIO, scenario), (_DEFAULTS, defaults)):
        if text:
            arrays[name] = np.array(text)
    temporary = target.with_name(f".{target.name}.part")
    try:
        with temporary.open("wb") as stream:
            np.savez_compressed(stream, **arrays)
        temporary.replace(target)
    except OSError as err:
        if temporary.is_file():
            temporary.unlink()
        raise RecordingError(
            f"{target}: cannot be written ({err.strerror or err}); required a writable folder "
            "with room for the file; choose another --out"
        ) from err
    return target


def agents_in(path: str | Path) -> tuple[str, ...]:
    """Return the agents whose flights a file holds; one without a name in a file of one flight.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    with _members_of(path) as members:
        names = (name.removesuffix(_SUFFIX) for name in members.namelist())
        found = dict.fromkeys(name.rpartition(".")[0] for name in names)
    return tuple(filter(None, found)) or ("",)


def _stored(agent: str, name: str) -> str:
    """Return under which name an array of an agent is stored."""
    return f"{agent}.{name}" if agent and name not in _SHARED else name


def _read(
    path: str | Path, *names: str, optional: Collection[str] = (_SCENARIO, _DEFAULTS)
) -> dict[str, Any]:
    """Return members of a file by name, but for the ``optional`` ones that an older file lacks."""
    with _members_of(path) as members:
        known = set(members.namelist())
        wanted = [n for n in names if n not in optional or f"{n}{_SUFFIX}" in known]
        return {name: _member(members, name) for name in wanted}


@contextmanager
def _members_of(path: str | Path) -> Iterator[zipfile.ZipFile]:
    try:
        with Path(path).open("rb") as stream, zipfile.ZipFile(stream) as members:
            yield members
    except UNREADABLE as err:
        raise RecordingError(
            f"{path}: cannot be read as a flight ({err}); required a .npz file written by "
            "`gnc simulate --out`; fly again"
        ) from err


def _member(members: zipfile.ZipFile, name: str) -> Any:
    # One array at a time: np.load leaves the file open where the archive is torn.
    with members.open(f"{name}{_SUFFIX}") as stream:
        return np.lib.format.read_array(stream, allow_pickle=False)
