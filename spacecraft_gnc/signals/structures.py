"""Fields of the standard ROS 2 messages that signals nest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

CODES: Final[Mapping[str, str]] = {
    "bool": "?",
    "byte": "B",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""Codes of the module `struct` by primitive type."""
TEXT: Final = "string"
SEQUENCE: Final = -1
"""Count of a sequence's elements, which each message states."""
HEADER: Final = "std_msgs/Header"
TIME: Final = "builtin_interfaces/Time"
VECTOR3: Final = "geometry_msgs/Vector3"
QUATERNION: Final = "geometry_msgs/Quaternion"
POSE: Final = "geometry_msgs/Pose"
WRENCH: Final = "geometry_msgs/Wrench"

_DEFINITIONS: Final = """
builtin_interfaces/Time: int32 sec, uint32 nanosec
builtin_interfaces/Duration: int32 sec, uint32 nanosec
std_msgs/Header: builtin_interfaces/Time stamp, string frame_id
std_msgs/ColorRGBA: float32 r, float32 g, float32 b, float32 a
geometry_msgs/Point: float64 x, float64 y, float64 z
geometry_msgs/Vector3: float64 x, float64 y, float64 z
geometry_msgs/Quaternion: float64 x, float64 y, float64 z, float64 w
geometry_msgs/Pose: geometry_msgs/Point position, geometry_msgs/Quaternion orientation
geometry_msgs/Wrench: geometry_msgs/Vector3 force, geometry_msgs/Vector3 torque
diagnostic_msgs/KeyValue: string key, string value
diagnostic_msgs/DiagnosticStatus: byte level, string name, string message, string hardware_id,
    diagnostic_msgs/KeyValue[] values
sensor_msgs/CompressedImage: std_msgs/Header header, string format, uint8[] data
visualization_msgs/UVCoordinate: float32 u, float32 v
visualization_msgs/MeshFile: string filename, uint8[] data
visualization_msgs/Marker: std_msgs/Header header, string ns, int32 id, int32 type, int32 action,
    geometry_msgs/Pose pose, geometry_msgs/Vector3 scale, std_msgs/ColorRGBA color,
    builtin_interfaces/Duration lifetime, bool frame_locked, geometry_msgs/Point[] points,
    std_msgs/ColorRGBA[] colors, string texture_resource, sensor_msgs/CompressedImage texture,
    visualization_msgs/UVCoordinate[] uv_coordinates, string text, string mesh_resource,
    visualization_msgs/MeshFile mesh_file, bool mesh_use_embedded_materials
"""


def _parse(text: str) -> dict[str, dict[str, str]]:
    joined = text.replace(",\n", ",").strip().splitlines()
    lines = (line.partition(":") for line in joined)
    return {
        name: {field: kind for kind, field in (pair.split() for pair in members.split(","))}
        for name, _, members in lines
    }


STRUCTURES: Final[Mapping[str, Mapping[str, str]]] = _parse(_DEFINITIONS)
"""Kinds of the fields, in order of declaration, by type ``pkg/Type``."""


class Kind(NamedTuple):
    """A field's type, taken apart."""

    base: str
    """Primitive, `TEXT`, or a name in `STRUCTURES`."""
    n: int | None
    """Elements of an array; `SEQUENCE`; None: one value."""


def parse_kind(kind: str) -> Kind:
    """Take apart a type as a .msg file writes it: ``float64``, ``float64[9]``, ``float64[]``.

    Raises
    ------
    ValueError
        If it is not known.
    """
    base, bracket, rest = kind.partition("[")
    if base not in CODES and base != TEXT and base not in STRUCTURES:
        known = ", ".join([*CODES, TEXT, *STRUCTURES])
        raise ValueError(f"field type: received {kind!r}; required one of {known}; correct it")
    if not bracket:
        return Kind(base, None)
    return Kind(base, SEQUENCE if rest == "]" else int(rest[:-1]))


def numbers_in(kind: str) -> str | None:
    """Return the `struct` codes of a type that holds a fixed count of numbers; None of others."""
    base, count = parse_kind(kind)
    if base == TEXT or count == SEQUENCE:
        return None
    if base in CODES:
        codes: str | None = CODES[base]
    else:
        parts = [numbers_in(member) for member in STRUCTURES[base].values()]
        codes = None if None in parts else "".join(part for part in parts if part is not None)
    return codes if codes is None or count is None else codes * count
