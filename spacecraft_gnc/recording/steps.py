"""The topics of a flight whose messages carry a control step: names, types, versions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import Bag

PACKAGE: Final = "spacecraft_gnc_msgs"
STATE: Final = "attitude_state"
REFERENCE: Final = "attitude_reference"
ACCEPTED_TARGET: Final = "accepted_target"
TORQUE: Final = "torque_command"
SOLVER_STATUS: Final = "solver_status"
GOVERNOR_STATUS: Final = "governor_status"
INVARIANTS: Final = "plant_invariants"
WALL_TIMING: Final = "wall_timing"
TYPES: Final[Mapping[str, str]] = {
    STATE: f"{PACKAGE}/msg/AttitudeState",
    REFERENCE: f"{PACKAGE}/msg/AttitudeReference",
    ACCEPTED_TARGET: f"{PACKAGE}/msg/AttitudeReference",
    TORQUE: f"{PACKAGE}/msg/TorqueCommand",
    SOLVER_STATUS: f"{PACKAGE}/msg/SolverStatus",
    GOVERNOR_STATUS: f"{PACKAGE}/msg/GovernorStatus",
    INVARIANTS: f"{PACKAGE}/msg/PlantInvariants",
    WALL_TIMING: f"{PACKAGE}/msg/WallTiming",
}
"""Type of each topic of a flight, by the last part of its name."""
TARGET: Final = "target_attitude"
"""Of users; what it says counts where the governor takes it."""
SPARSE: Final = (TARGET, ACCEPTED_TARGET, WALL_TIMING)
"""Topics without a message at most steps, so that a gap in their steps is no loss."""
UNIQUE: Final = (STATE, INVARIANTS)
"""Topics of the plant: two messages of one step differ only if two runs are in the bag."""
TYPE_HASHES: Final[Mapping[str, str]] = {
    f"{PACKAGE}/msg/{leaf}": f"RIHS01_{digest}"
    for leaf, digest in {
        "AttitudeState": "1e8805516c0c5a75a2ad9192a0d5f9d4db16bb73fd628ea1199be42b0d2721c1",
        "AttitudeReference": "923a4386de8a598381bc7e354b33db117b80a6d93d36f5c8cf281dcc14b54e2e",
        "TorqueCommand": "ff7c97d0f625f35b8975f46232f4b8e3765a528f2bd01b3dd88c8d0108fad1f6",
        "SolverStatus": "3cb9ca36d5ae3972d64e9ad1321f518b5aa8aea56046fb8b6037240357202134",
        "GovernorStatus": "a43992019b55bed2c1ce5d626f45f5c144865f829790ad3074b96eb37c08e4fb",
        "PlantInvariants": "143610bd223843d478298752859448a143e1ee9759e70cf186e6136ba22f2f7a",
        "WallTiming": "be8d8e587166b32c1c61dedefdac670d3d83f5994d41dfd412be757fa0abbc90",
    }.items()
}
"""REP-2011 hash of each of these types in this version of the messages."""


def flight_topics(bag: Bag, names: Iterable[str], namespace: str | None = None) -> dict[str, str]:
    """Return the name of each topic of one flight by its full name; one not recorded is left out.

    Raises
    ------
    RecordingError
        If the bag is of another package, holds several spacecraft, or a topic has another type or
        another version of its type.
    """
    prefix = flight_namespace(bag, namespace)
    topics = {f"{prefix}/{name}": name for name in names if f"{prefix}/{name}" in bag.topics}
    for topic, name in topics.items():
        _check_type(bag, topic, TYPES[name])
    return topics


def namespace_topics(bag: Bag, namespace: str | None = None) -> dict[str, str]:
    """Return the full name of each topic of one spacecraft by its name in the namespace.

    Raises
    ------
    RecordingError
        If the bag holds no spacecraft, or several.
    """
    prefix = f"{flight_namespace(bag, namespace)}/"
    return {name.removeprefix(prefix): name for name in bag.topics if name.startswith(prefix)}


def _check_type(bag: Bag, topic: str, required: str) -> None:
    if bag.topics[topic] != required:
        raise RecordingError(
            f"{bag.path}: {topic} has type {bag.topics[topic]}; required {required}; the bag "
            "was recorded from another package"
        )
    received = bag.type_hash(topic)
    if received != TYPE_HASHES[required]:
        raise RecordingError(
            f"{bag.path}: {topic}: received {required} with type hash {received}; required "
            f"{TYPE_HASHES[required]}, this version's; read it with the version that flew, or "
            "record again"
        )


def flight_namespace(bag: Bag, namespace: str | None) -> str:
    """Return the prefix, without the last slash, of the flight's topics."""
    prefixes = [
        topic.removesuffix(f"/{STATE}") for topic in bag.topics if topic.endswith(f"/{STATE}")
    ]
    if namespace is not None:
        prefixes = [prefix for prefix in prefixes if prefix.strip("/") == namespace.strip("/")]
    if not prefixes:
        recorded = ", ".join(sorted(bag.topics)) or "none"
        where = f" in namespace {namespace}" if namespace is not None else ""
        raise RecordingError(
            f"{bag.path}: no topic {STATE}{where}; required a flight recorded by spacecraft_gnc; "
            f"topics in the bag: {recorded}"
        )
    if len(prefixes) > 1:
        raise RecordingError(
            f"{bag.path}: several spacecraft ({', '.join(sorted(prefixes))}); required one; name "
            "it with --namespace"
        )
    return prefixes[0]
