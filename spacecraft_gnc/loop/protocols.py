"""Interfaces of the closed loop: plant, controller and governor.

Nodes, `ClosedLoop` and users' own packages meet here. The seams are generic in the state S, the
control U and the target or reference R of a vehicle. A state is a named tuple whose ``step`` is the
number of the control step that it starts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar

from numpy.typing import NDArray

from spacecraft_gnc.status import Source
from spacecraft_gnc.types import GovernorDecision, Reference, State

if TYPE_CHECKING:  # a scenario is checked without them
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.signals.signal import Signal

__all__ = [
    "Command",
    "Controller",
    "Flown",
    "Governor",
    "GovernorDecision",
    "Plant",
    "Reference",
    "Source",
    "State",
    "Stretch",
]
S_co = TypeVar("S_co", covariant=True)
S_contra = TypeVar("S_contra", contravariant=True)
U_contra = TypeVar("U_contra", contravariant=True)
R_contra = TypeVar("R_contra", contravariant=True)
R = TypeVar("R")


class Command(NamedTuple):
    """Control for one step, and where it comes from."""

    control: Any
    """What the actuators are to do, such as a body torque (3,) [N m]."""
    source: Source = Source.METHOD
    report: Any = None
    """What the method says of it, with a ``status``; None where it has nothing to say."""

    @property
    def is_fallback(self) -> bool:
        """As `Source.is_fallback`; another package's method may give the number alone."""
        return Source(self.source).is_fallback

    @property
    def status(self) -> Any:
        """How the step ended, by the method's report; None: there is none."""
        return None if self.report is None else self.report.status


class Flown(NamedTuple):
    """Control steps that were flown at once."""

    n_steps: int
    command: Command
    """Of the last one; its source and status are those of all."""
    columns: Mapping[str, NDArray[Any]]
    """Columns of the flight in which they differ, by name, a row for each step."""


class Stretch(Protocol):
    """Many control steps of a plant, its controller and its governor at once, in compiled code."""

    def fly(self, state: Any, reference: Any, most: int) -> Flown | None:
        """Fly up to ``most`` steps under a constant reference; None: the first one needs Python.

        Plant and controller are left as single steps would have left them.
        """


class Plant(Protocol[S_co, U_contra]):
    """A simulated vehicle, advanced one control step at a time.

    A vehicle of several craft (`vehicles.vehicle.Vehicle.craft`) has them all in one plant: its
    control, its idle control and the sources hold a row, or an element, for each craft in their
    order.

    A class whose actuators have limits also has ``actuators`` (`plant.actuators.Actuators`), which
    it drives by each control: a loop logs what they give, and a node tells of the steps on which
    that is less than asked for.

    A class may also have ``stretch(controller, governor, most)``: the `Stretch` that flies up to
    ``most`` steps of that loop at once, with the numbers of single steps; None where nothing does,
    as where the governor's decision depends on the state.
    """

    period: float
    """Control period [s]."""
    n_steps: int
    """Control steps of the scenario."""

    @property
    def flight(self) -> type[Flight]:
        """What a flight of it keeps of each step."""

    @property
    def state(self) -> S_co:
        """State at the start of the current control step."""

    def step(self, control: U_contra, /) -> S_co:
        """Hold ``control`` for one control period and return the new state."""

    @property
    def idle_control(self) -> Any:
        """Control where no command came."""

    def outputs(self, applied: tuple[Any, Any]) -> Iterable[tuple[Signal, Any]]:
        """Return what a node publishes at the start of the current step, the state first.

        ``applied``: control and its source over the step that ended now; of several craft, their
        controls stacked (n, ...), and a tuple of n sources.
        """

    def warm_up(self) -> None:
        """Compile or load everything that `step` needs."""

    def reset(self) -> None:
        """Return to the initial state."""


class Controller(Protocol[S_contra, R_contra]):
    """A control law: state and reference in, command out; it never raises in flight.

    That of a vehicle of several craft commands all of them, a row of ``control`` for each, and has
    an attribute ``craft``: the controllers (tuple) of the single craft in their order. The node of
    a craft hosts one of these, whose ``control`` is that row.
    """

    period: float
    """Control period [s]."""
    name: str
    """Method name, as in the scenario's ``method:``."""
    slow: bool
    """Whether a command may take longer than some milliseconds: a node then computes it in a
    thread of its own, and never two at a time.

    A class may also have ``memory()``: what of the past the next command depends on, as a tuple of
    plain values (`loop.plain`), or None where that cannot be told now; and ``recall(memory)``, from
    which on one that is built of the same scenario goes on as that one would have, to the last bit.
    Of a class without them, a restarted node answers all steps again (`loop.past`).

    A class may also declare its ``traits``
    (`vehicles.vehicle.MethodTraits`). One that computes something beside its commands, in a thread
    of its own, has an attribute ``waits``: whether a step waits for what is due at it, which makes
    flights repeatable; a node that keeps to wall time sets it to false."""

    def warm_up(self) -> None:
        """Compile or load everything that `command` needs."""

    def reset(self) -> None:
        """Forget the past: the next command starts cold."""

    def command(self, state: S_contra, reference: R_contra) -> Command:
        """Return the command of the control step that starts at ``state``."""


class Governor(Protocol[S_contra, R]):
    """Shapes the reference so that the loop behind it keeps its constraints."""

    name: str
    """Law, as in the scenario's ``governor:``. Where its reference moves by itself, the class also
    says ``moves = True`` (`vehicles.vehicle.GovernorLaw`)."""
    slow: bool
    """Whether a decision may take longer than some milliseconds: a node then makes it in a thread
    of its own, and never two at a time. ``waits``, ``memory`` and ``recall`` are those of a
    `Controller`; targets taken belong to the memory."""

    @property
    def target(self) -> R:
        """What is finally wanted, such as an attitude (3, 3), body to inertial."""

    def set_target(self, target: R, /) -> None:
        """Ask for a new target.

        Raises
        ------
        GncError
            If it is inadmissible, with the reason and the margin; the last target then stays.
        """

    def warm_up(self) -> None:
        """Compile or load everything that `decide` needs."""

    def reset(self) -> None:
        """Forget the past."""

    def decide(self, state: S_contra) -> Any:
        """Return the decision, with its ``reference``, for the step that starts at ``state``."""
