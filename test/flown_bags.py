"""Bags of simulated flights without ROS: cores fly, rosbags serializes, our writer records."""

from __future__ import annotations

import copy
import math
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import case_1
import numpy as np
from mcap.reader import make_reader
from recording.bags import CODEC, SPARSE

from spacecraft_gnc.governors.planned.report import PlanReport
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp import Status, linearize
from spacecraft_gnc.ocp.assembly import assemble
from spacecraft_gnc.ocp.reference import as_reference
from spacecraft_gnc.ocp.rollout import Horizon
from spacecraft_gnc.parameters.declare import flatten, unflatten
from spacecraft_gnc.recording.qos import qos_yaml
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.scenario.scenario import sections_to_yaml
from spacecraft_gnc.signals import Signal, graph
from spacecraft_gnc.signals.attitude import ATTITUDE_ERROR, POSE, error_of
from spacecraft_gnc.signals.codec import padded
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.signals.message import period_ns, stamp_of
from spacecraft_gnc.signals.structures import VECTOR3
from spacecraft_gnc.vehicles.rigid_body.controllers.report import plan_of
from spacecraft_gnc.vehicles.rigid_body.outputs import Outputs
from spacecraft_gnc.vehicles.rigid_body.signals import ATTITUDE_PLAN, PLAN_STATUS, SIGNALS

SECTIONS: dict[str, dict[str, Any]] = {
    "plant": {
        **case_1.PLANT,
        "duration": 4.8,
        "initial_rotation_vector": [0.25, 0.5, 0.5],
        "initial_momentum": [0.01, 0.0, -0.02],
    },
    "nmpc_controller": case_1.controller(),
}
"""Twelve steps of Case I of Gupta et al. 2015, moving from the start."""
TERMINAL_SET: dict[str, dict[str, Any]] = {
    "plant": {
        "inertia": [10.0, 0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0, 8.0],
        "time_step": 0.1,
        "duration": 1.0,
        "initial_rotation_vector": [0.352, 0.264, 0.0],
        "initial_momentum": [0.0, 0.0, 0.0],
    },
    "nmpc_controller": {
        "method": "terminal_set",
        "horizon": 60,
        "max_torque": 0.02,
        "weights": {
            "stage_attitude": 1.0,
            "stage_rate": [3.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 5.0],
            "stage_torque": 1000.0,
        },
        "stage_cost_scale": 0.9,
        "terminal_set": "true",
    },
}
"""Ten steps with an active terminal set."""


def sections(**changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return these sections with some values changed, by section name."""
    merged = copy.deepcopy(SECTIONS)
    for name, values in changes.items():
        merged.setdefault(name, {}).update(values)
    merged["nmpc_controller"] = case_1.controller(**changes.get("nmpc_controller", {}))
    return merged


def announce_all(writer: BagWriter, without: Collection[str] = (), namespace: str = "") -> None:
    """Announce every topic that a recorder does, but for some; those of the graph once."""
    for signal in (*SIGNALS, *graph.SIGNALS):
        name = f"/{signal.name.strip('/')}"
        name = name if signal.shared else f"{namespace}{name}"
        if signal.recorded and name not in without and name not in writer.counts:
            writer.add_topic(
                name,
                signal.type,
                CODEC.text(signal.type),
                qos_yaml=qos_yaml(signal.qos),
                type_hash=signal.type_hash,
                gapless=signal.every_step and signal.is_stepped and signal.name not in SPARSE,
            )


def nested(flat: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return sections as in a scenario file."""
    return {name: unflatten(flatten(values)) for name, values in flat.items()}


def tell(bag: BagWriter, flat: Mapping[str, Mapping[str, Any]]) -> None:
    """Attach sections and their defaults."""
    bag.attach("scenario.yaml", "application/yaml", sections_to_yaml(nested(flat)).encode())
    taken = from_sections(flat).stated_defaults()
    bag.attach("defaults.yaml", "application/yaml", taken.encode())


def fly(
    folder: Path,
    flown: Mapping[str, Mapping[str, Any]] = SECTIONS,
    failing: Collection[int] = (),
    targets: Mapping[int, Any] | None = None,
    late: Collection[int] = (),
    anew: Collection[int] = (),
    failure: Status = Status.MAX_ITERATIONS,
    blind: bool = False,
    claimed: Mapping[str, Mapping[str, Any]] | None = None,
    idle: bool = False,
) -> Path:
    """Fly a scenario and record it as the nodes would; return the bag.

    Solves of the steps ``failing`` falsely report a ``failure``, and the fallback ladder is
    applied; a ``blind`` controller does not search for standstills, an ``idle`` one reports plans
    without any torque as converged; the scenario ``claimed`` is recorded instead of the flown one.

    At the steps of ``targets`` the target changes. At the steps ``late`` of a free run no command
    arrives in time, and before the steps ``anew`` the governor is restarted.
    """
    scenario = from_sections(flown)
    with BagWriter(folder / "bag") as bag:
        announce_all(bag)
        tell(bag, flown if claimed is None else claimed)
        recorder = _Recorder(bag, scenario.period)
        recorder.setup(Outputs(scenario))
        loop = scenario.build()
        for core in (loop.plant, loop.controller, loop.governor):
            core.reset()
        if failing:
            solving = getattr(loop.controller, "tracking", loop.controller)
            solving.solver = _Failing(solving.solver, failing, failure)
        if idle:
            loop.controller.solver = _Idle(loop.controller.solver)
        if blind:
            loop.controller._monitor = None
        state, applied, source = loop.plant.state, np.zeros(3), Source.ZERO
        last, misses = (applied, source), 0
        for k in range(loop.plant.n_steps + 1):
            recorder.state(k, loop.plant, applied, source)
            if k == loop.plant.n_steps:
                break
            recorder.signal(CLOCK, k, [stamp_of(k, period_ns(scenario.period))])
            if k in anew:
                loop.governor.reset()
            if k in (targets or {}):
                loop.governor.set_target(targets[k])
                recorder.attitude("accepted_target", k, targets[k])
            if failing:
                solving.solver.step = k
            decision = loop.governor.decide(state)
            recorder.decision(k, decision)
            command = loop.controller.command(state, decision.reference)
            recorder.command(k, command, loop.controller.name)
            recorder.signal(ATTITUDE_ERROR, k, error_of(state.attitude, decision.reference))
            misses = misses + 1 if k in late else 0
            last = last if misses else (command.control, command.source)
            gone = misses > scenario.plant.max_held_steps
            applied, source = (np.zeros(3), Source.ZERO) if gone else last
            recorder.timing(k + 1, held=len([step for step in late if step <= k]))
            state = loop.plant.step(applied)
    return folder / "bag"


class _Failing:
    """A solver that falsely reports a failure at some steps."""

    def __init__(self, solver: Any, failing: Collection[int], failure: Status) -> None:
        self._solver, self._failing, self._failure = solver, failing, failure
        self.step = 0

    def solve(self, *problem: Any) -> Any:
        found = self._solver.solve(*problem)
        failed = self.step in self._failing
        return found.replace(status=self._failure) if failed else found


class _Idle:
    """A solver whose plans have zero torque, with the matching certificates."""

    def __init__(self, solver: Any) -> None:
        self.ocp = solver.ocp

    def solve(self, attitude: Any, momentum: Any, reference: Any, warm_start: Any = None) -> Any:
        ocp, still = self.ocp, np.zeros((self.ocp.horizon, 3))
        horizon = Horizon(ocp, still, attitude, momentum, reference)
        residual = np.linalg.norm(horizon.gradient()) / (2.0 * ocp.time_step)
        plan = (horizon.attitudes, horizon.momenta, still, horizon.costates)
        cost = ocp.cost(still, attitude, momentum, reference)
        outcome = (Status.CONVERGED, 0, float(residual), cost)
        solution = assemble(ocp, plan, as_reference(reference), outcome, 0.0, "backward_sweep")
        return solution.replace(min_curvature=linearize(solution).min_curvature)


class _Recorder:
    """Writes the messages that the nodes publish for a step."""

    def __init__(self, bag: BagWriter, period: float) -> None:
        self._bag = bag
        self._period_ns = round(period * 1e9)

    def _write(self, topic: str, name: str, step: int, frame: str, **values: Any) -> None:
        stamp = step * self._period_ns
        header = CODEC.header(step, frame, stamp_ns=stamp)
        data = padded(CODEC.dump(name, header=header, step=step, **values))
        self._bag.write(f"/{topic}", stamp, stamp, data)

    def setup(self, outputs: Outputs) -> None:
        """Write what the controller tells at its start."""
        for signal, value in outputs.setup():
            self.signal(signal, 0, value)

    def signal(self, signal: Signal, step: int, value: Any) -> None:
        """Write a message of a standard type, encoded by its signal."""
        stamp = step * self._period_ns
        data = signal.encode(stamp_of(step, self._period_ns), step, value)
        self._bag.write(f"/{signal.name.strip('/')}", stamp, stamp, data)

    def state(self, k: int, plant: Any, applied: Any, source: int) -> None:
        state = plant.state
        self._write(
            "attitude_state", "AttitudeState", k, "inertial",
            attitude=state.attitude.ravel(),
            orientation=CODEC.quaternion(state.attitude),
            angular_momentum=CODEC.vector(state.momentum),
            angular_velocity=CODEC.vector(plant.angular_velocity()),
        )  # fmt: skip
        energy, momentum, defect = plant.invariants()
        self._write(
            "plant_invariants", "PlantInvariants", k, "inertial",
            kinetic_energy=energy,
            inertial_momentum=CODEC.vector(momentum),
            orthogonality_error=defect,
            applied_torque=CODEC.vector(plant.actuators.given(applied)),
            applied_source=int(source),
            external_torque=CODEC.vector(plant.external_torque),
        )  # fmt: skip
        for signal, value in plant.outputs((applied, source)):
            if signal is POSE:
                self.signal(signal, k, value)

    def timing(self, k: int, held: int) -> None:
        wall = ("wall_elapsed", "wall_latency", "wall_deadline_slack")
        counts = {"missed_deadlines": held, "held_commands": held, "rejected_messages": 0}
        values = dict.fromkeys(wall, math.nan) | {"wall_elapsed": 0.1 * k} | counts
        self._write("wall_timing", "WallTiming", k, "", **values)

    def attitude(self, topic: str, k: int, attitude: Any, *motion: Any) -> None:
        rate, torque = motion or (np.zeros(3), np.zeros(3))
        self._write(
            topic, "AttitudeReference", k, "inertial",
            attitude=attitude.ravel(),
            orientation=CODEC.quaternion(attitude),
            angular_velocity=CODEC.vector(rate),
            torque=CODEC.vector(torque),
        )  # fmt: skip

    def decision(self, k: int, decision: Any) -> None:
        self.attitude("attitude_reference", k, *decision.reference)
        self._write(
            "governor_status", "GovernorStatus", k, "inertial",
            alpha=decision.alpha, admissible=decision.admissible, margin=decision.margin,
            active_constraint=decision.active_constraint, evaluations=decision.evaluations,
            violation_step=decision.violation_step, horizon=decision.horizon,
            waypoints=decision.waypoints,
        )  # fmt: skip
        self.plan(k, plan_of(decision))

    def plan(self, k: int, report: PlanReport | None) -> None:
        """Write what is told of a step along a plan."""
        if report is None:
            return
        told = [(ATTITUDE_PLAN, "AttitudePlan", planned) for planned in report.told]
        for signal, name, value in [*told, (PLAN_STATUS, "PlanStatus", report)]:
            fields = dict(zip(signal.fields, signal.pack(value), strict=True))
            for field, part in fields.items():
                if isinstance(part, np.ndarray):
                    vector = signal.fields[field].kind == VECTOR3
                    fields[field] = CODEC.vector(part) if vector else np.ravel(part)
            self._write(signal.name, name, k, "body", **fields)

    def command(self, k: int, command: Any, method: str) -> None:
        torque = CODEC.vector(command.control)
        source = int(command.source)
        self._write("torque_command", "TorqueCommand", k, "body", torque=torque, source=source)
        self._write("solver_status", "SolverStatus", k, "body", method=method, **_solve(command))
        self.plan(k, plan_of(command))


def _solve(command: Any) -> dict[str, Any]:
    found, standstill = (None, None) if command.report is None else command.report[:2]
    wall = {"wall_solve_time": 1e-4, "wall_deadline_slack": math.nan}
    if found is None:
        names = ("residual", "cost", "torque_margin", "min_curvature", "closed_loop_radius")
        plan = ("zone_margins", "predicted_attitudes", "predicted_momenta", "predicted_torques")
        return (
            wall
            | {"formulation": "", "active_constraint": "", "status": 255, "iterations": 0}
            | {"first_costate": np.full(6, math.nan)}
            | dict.fromkeys(names, math.nan)
            | dict.fromkeys(plan, np.full(0, math.nan))
        )
    return wall | {
        "formulation": found.formulation,
        "status": int(command.status),
        "iterations": found.iterations,
        "residual": found.residual,
        "cost": found.cost,
        "first_costate": np.asarray(found.costates[0]),
        "torque_margin": found.torque_margin,
        "zone_margins": np.asarray(found.zone_margins),
        "min_curvature": found.min_curvature,
        "closed_loop_radius": standstill.radius if standstill else math.nan,
        "active_constraint": standstill.active_constraint if standstill else "",
        "predicted_attitudes": found.attitudes.ravel(),
        "predicted_momenta": found.momenta.ravel(),
        "predicted_torques": found.torques.ravel(),
    }


def messages_of(bag: Path) -> list[tuple[str, int, bytes]]:
    """Return (topic, log time, bytes) of a bag, in the order of recording."""
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream:
        found = make_reader(stream).iter_messages(log_time_order=False)
        return [(channel.topic, message.log_time, message.data) for _, channel, message in found]


def rewrite(
    bag: Path,
    folder: Path,
    messages: list[tuple[str, int, bytes]],
    lost: Mapping[str, int] | None = None,
    without: Collection[str] = (),
) -> Path:
    """Rewrite the bag with other messages and valid checksums.

    ``lost`` gives the number of messages reported missing per topic; topics ``without`` a channel.
    """
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream, BagWriter(folder) as writer:
        announce_all(writer, without)
        for item in make_reader(stream).iter_attachments():
            writer.attach(item.name, item.media_type, item.data)
        for topic, stamp, data in messages:
            writer.write(topic, stamp, stamp, data)
        for topic, count in (lost or {}).items():
            writer.report_loss(topic, count)
    return folder


def flipped(data, bit):
    """Return the bytes with one bit changed, counted from the first byte."""
    changed = bytearray(data)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def edited(name, **changes):
    """Return a change of a message: fields with a value added, or replaced by a function."""
    full = f"spacecraft_gnc_msgs/msg/{name}"

    def change(data):
        message = CODEC.store.deserialize_cdr(data, full)
        for key, value in changes.items():
            old = getattr(message, key)
            setattr(message, key, value(old) if callable(value) else old + value)
        return padded(bytes(CODEC.store.serialize_cdr(message, full)))

    return change


def first_of(audit):
    check, difference = audit.first
    return check.name, difference.step, difference.field
