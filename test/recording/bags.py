"""Message definitions, serialized messages and whole bags for tests; no ROS is needed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from spacecraft_gnc import lie
from spacecraft_gnc.recording.qos import qos_yaml
from spacecraft_gnc.recording.schema_text import schema_text
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.signals.qos import QosProfile
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight

SPARSE = ("target_attitude", "accepted_target", "wall_timing", "attitude_plan", "plan_status")
MESSAGES = Path(__file__).parents[2] / "msg_defs" / "msg"
PERIOD = 0.4  # [s]
STANDARD = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "std_msgs/msg/String": "string data\n",
    "geometry_msgs/msg/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/msg/Vector3Stamped": "std_msgs/Header header\nVector3 vector\n",
    "geometry_msgs/msg/Wrench": "Vector3 force\nVector3 torque\n",
    "geometry_msgs/msg/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
}


def definition(type_name):
    """Return a .msg text: ours from the source tree, standard ones from the table above."""
    if type_name in STANDARD:
        return STANDARD[type_name]
    return (MESSAGES / f"{type_name.split('/')[-1]}.msg").read_text()


class Codec:
    """Serializes our messages with rosbags, from nothing but their definitions."""

    def __init__(self):
        self.store = get_typestore(Stores.EMPTY)
        self.texts = {}
        for path in sorted(MESSAGES.glob("*.msg")):
            name = f"spacecraft_gnc_msgs/msg/{path.stem}"
            self.texts[name] = schema_text(name, definition)
            self.store.register(get_types_from_msg(self.texts[name], name))
        self.texts["std_msgs/msg/String"] = STANDARD["std_msgs/msg/String"]
        self.store.register(get_types_from_msg("string data", "std_msgs/msg/String"))

    def text(self, type_name):
        """Return the definition of one of our messages or of a standard one."""
        if type_name not in self.texts:
            return get_typestore(Stores.ROS2_JAZZY).generate_msgdef(type_name, ros_version=2)[0]
        return self.texts[type_name]

    def make(self, name, **values):
        """Return a message object; ``name`` as ``std_msgs/Header`` or our ``AttitudeState``."""
        package, _, leaf = (name if "/" in name else f"spacecraft_gnc_msgs/{name}").partition("/")
        return self.store.types[f"{package}/msg/{leaf}"](**values)

    def header(self, step, frame="inertial", stamp_ns=None):
        """Return a header with the stamp of a control step, or another one."""
        nanoseconds = round(step * PERIOD * 1e9) if stamp_ns is None else stamp_ns
        stamp = self.make(
            "builtin_interfaces/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9
        )
        return self.make("std_msgs/Header", stamp=stamp, frame_id=frame)

    def vector(self, values):
        """Return a Vector3."""
        return self.make(
            "geometry_msgs/Vector3", **dict(zip("xyz", map(float, values), strict=True))
        )

    def quaternion(self, attitude):
        """Return a Quaternion."""
        xyzw = map(float, lie.to_quaternion_xyzw(attitude))
        return self.make("geometry_msgs/Quaternion", **dict(zip("xyzw", xyzw, strict=True)))

    def state(self, step, attitude, momentum, stamp_ns=None):
        return self.dump(
            "AttitudeState",
            header=self.header(step, stamp_ns=stamp_ns),
            step=step,
            attitude=np.ravel(attitude),
            orientation=self.quaternion(attitude),
            angular_momentum=self.vector(momentum),
            angular_velocity=self.vector(momentum),
        )

    def reference(self, step, attitude):
        return self.dump(
            "AttitudeReference",
            header=self.header(step),
            step=step,
            attitude=np.ravel(attitude),
            orientation=self.quaternion(attitude),
            angular_velocity=self.vector(np.zeros(3)),
            torque=self.vector(np.zeros(3)),
        )

    def torque(self, step, torque, source=0):
        return self.dump(
            "TorqueCommand",
            header=self.header(step, "body"),
            step=step,
            torque=self.vector(torque),
            source=source,
        )

    def invariants(self, step, torque, source=0):
        return self.dump(
            "PlantInvariants",
            header=self.header(step),
            step=step,
            kinetic_energy=0.0,
            inertial_momentum=self.vector(np.zeros(3)),
            orthogonality_error=0.0,
            applied_torque=self.vector(torque),
            applied_source=source,
            external_torque=self.vector(np.zeros(3)),
        )

    def decision(self, step, alpha, margin):
        return self.dump(
            "GovernorStatus",
            header=self.header(step),
            step=step,
            alpha=alpha,
            admissible=True,
            margin=margin,
            active_constraint="",
            evaluations=1,
            violation_step=-1,
            horizon=0,
            waypoints=0,
        )

    def status(self, step, iterations, residual, cost, solve_time, status=0):
        empty = np.empty(0)
        return self.dump(
            "SolverStatus",
            header=self.header(step, "body"),
            step=step,
            method="shooting",
            formulation="backward_sweep",
            status=status,
            iterations=iterations,
            residual=residual,
            cost=cost,
            first_costate=np.zeros(6),
            torque_margin=0.0,
            zone_margins=empty,
            min_curvature=np.nan,
            closed_loop_radius=np.nan,
            active_constraint="",
            predicted_attitudes=empty,
            predicted_momenta=empty,
            predicted_torques=empty,
            wall_solve_time=solve_time,
            wall_deadline_slack=np.nan,
        )

    def dump(self, name, **values):
        """Return the CDR bytes of a message."""
        full = f"spacecraft_gnc_msgs/msg/{name}"
        return bytes(self.store.serialize_cdr(self.make(name, **values), full))


CODEC = Codec()
TOPICS = {
    "attitude_state": "AttitudeState",
    "attitude_reference": "AttitudeReference",
    "accepted_target": "AttitudeReference",
    "torque_command": "TorqueCommand",
    "governor_status": "GovernorStatus",
    "solver_status": "SolverStatus",
    "plant_invariants": "PlantInvariants",
    "attitude_plan": "AttitudePlan",
    "plan_status": "PlanStatus",
}


def random_flight(n, seed=0):
    """Return a flight of ``n`` steps of random numbers."""
    rng = np.random.default_rng(seed)
    attitude = np.array([lie.exp(rng.normal(size=3)) for _ in range(n + 1)])
    reference = np.array([lie.exp(rng.normal(size=3)) for _ in range(n)])
    momentum = rng.normal(size=(n + 1, 3))
    return RigidBodyFlight(
        period=PERIOD,
        time=PERIOD * np.arange(n),
        attitude=attitude[:-1],
        momentum=momentum[:-1],
        torque=rng.normal(size=(n, 3)),
        external_torque=np.zeros((n, 3)),
        reference=reference,
        reference_rate=np.zeros((n, 3)),
        reference_torque=np.zeros((n, 3)),
        target=np.full((n, 3, 3), np.nan),
        iterations=rng.integers(1, 9, n),
        residual=rng.random(n),
        cost=rng.random(n),
        solve_time=rng.random(n),
        status=np.zeros(n, dtype=np.int64),
        source=rng.integers(0, 5, n),
        alpha=rng.random(n),
        governor_margin=rng.random(n),
        plan=np.full(n, -1),
        plan_phase=np.full(n, -1),
        plan_error=np.full(n, np.nan),
        plan_torque=np.full((n, 3), np.nan),
        plan_momentum=np.full((n, 3), np.nan),
        final_attitude=attitude[-1],
        final_momentum=momentum[-1],
        final_reference=reference[-1],
    )


def flight_messages(flight):
    """Return (topic, step, bytes) of a flight, in the order in which the graph publishes them."""
    n = flight.n_steps
    items = []
    attitude = [*flight.attitude, flight.final_attitude]
    momentum = [*flight.momentum, flight.final_momentum]
    applied = [np.zeros(3), *flight.torque]
    sources = [0, *map(int, flight.source)]
    for k in range(n + 1):
        items.append(("attitude_state", k, CODEC.state(k, attitude[k], momentum[k])))
        items.append(("plant_invariants", k, CODEC.invariants(k, applied[k], sources[k])))
        if k < n:
            solve = (int(flight.iterations[k]), flight.residual[k], flight.cost[k])
            items.append(("attitude_reference", k, CODEC.reference(k, flight.reference[k])))
            decision = CODEC.decision(k, flight.alpha[k], flight.governor_margin[k])
            items.append(("governor_status", k, decision))
            items.append(("solver_status", k, CODEC.status(k, *solve, flight.solve_time[k])))
            torque = CODEC.torque(k, flight.torque[k], int(flight.source[k]))
            items.append(("torque_command", k, torque))
    return items


def announce(writer, namespace=""):
    """Announce the topics of a flight to a writer."""
    for topic, leaf in TOPICS.items():
        name = f"spacecraft_gnc_msgs/msg/{leaf}"
        writer.add_topic(
            f"{namespace}/{topic}",
            name,
            CODEC.texts[name],
            qos_yaml=qos_yaml(QosProfile(depth=1000)),
            type_hash=CODEC.store.hash_rihs01(name),
            gapless=topic not in SPARSE,
        )


def record(folder, items, scenario="", namespace="", **options):
    """Write a closed bag of messages, and return its folder."""
    with BagWriter(folder, **options) as writer:
        announce(writer, namespace)
        if scenario:
            writer.attach("scenario.yaml", "application/yaml", scenario.encode())
        for topic, step, data in items:
            stamp = round(step * PERIOD * 1e9)
            writer.write(f"{namespace}/{topic}", stamp, stamp, data)
    return folder
