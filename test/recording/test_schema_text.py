"""Message definitions: nesting, lookups and hashes."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from mcap_ros2._dynamic import generate_dynamic
from recording.bags import definition
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.schema_text import (
    InstalledInterfaces,
    canonical_name,
    fields,
    schema_text,
)

INSTALLED = InstalledInterfaces([Path(sys.prefix)])
RECORDED_STANDARD_TYPES = [
    "std_msgs/msg/String",
    "geometry_msgs/msg/PoseStamped",
    "builtin_interfaces/msg/Time",
    "diagnostic_msgs/msg/DiagnosticArray",
    "visualization_msgs/msg/MarkerArray",
    "rosgraph_msgs/msg/Clock",
]
OURS = "AttitudeReference AttitudeState GovernorStatus PlantInvariants SolverStatus TorqueCommand"


def test_each_nested_type_follows_once_after_a_separator():
    text = schema_text("spacecraft_gnc_msgs/msg/AttitudeState", definition)
    root, *nested = text.split("=" * 80 + "\n")
    assert [part.splitlines()[0] for part in nested] == [
        "MSG: std_msgs/Header",
        "MSG: builtin_interfaces/Time",
        "MSG: geometry_msgs/Quaternion",
        "MSG: geometry_msgs/Vector3",
    ]
    assert [name for _, name in fields(root)] == [name for _, name in fields(text)]


@pytest.mark.parametrize("leaf", [*OURS.split(), "WallTiming"])
def test_our_types_parse_in_rosbags_and_mcap_ros2(leaf):
    name = f"spacecraft_gnc_msgs/msg/{leaf}"
    text = schema_text(name, definition)
    assert name in get_types_from_msg(text, name)
    assert name in generate_dynamic(name, text)


@pytest.mark.parametrize("name", RECORDED_STANDARD_TYPES)
def test_installed_types_equal_those_of_ros_2_jazzy(name):
    try:
        text = schema_text(name, INSTALLED.definition)
    except RecordingError:
        pytest.skip("the ROS message packages are not installed")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, name))
    assert store.hash_rihs01(name) == get_typestore(Stores.ROS2_JAZZY).hash_rihs01(name)
    assert INSTALLED.type_hash(name) == store.hash_rihs01(name)
    assert name in generate_dynamic(name, text)


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("float64[9] attitude  # row-major", [("float64", "attitude")]),
        ("string<=10 name", [("string", "name")]),
        ("geometry_msgs/Point[] points", [("geometry_msgs/Point", "points")]),
        ("Other[<=3] others", [("Other", "others")]),
        ("float64 w 1.0", [("float64", "w")]),
        ("uint8 OPTIMAL=0", []),
        ("string NAME = 'x'", []),
        ("# a comment about Thing name", []),
        ("", []),
    ],
)
def test_fields_are_told_from_constants_and_comments(line, found):
    assert list(fields(line)) == found


def test_a_name_without_package_means_the_same_package():
    texts = {"p/msg/A": "B b\n", "p/msg/B": "uint8 x\n"}
    assert "MSG: p/B" in schema_text("p/A", texts.__getitem__)


def test_types_that_nest_each_other_end():
    texts = {"p/msg/A": "B b\nC c\n", "p/msg/B": "C c\n", "p/msg/C": "uint8 x\n"}
    assert schema_text("p/msg/A", texts.__getitem__).count("MSG: p/C") == 1


def test_names_are_checked():
    assert canonical_name("std_msgs/Header") == "std_msgs/msg/Header"
    with pytest.raises(RecordingError, match=r"received 'Header'; required pkg/msg/Type"):
        canonical_name("Header")


def test_an_unknown_type_names_where_it_was_sought(tmp_path, monkeypatch):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    with pytest.raises(RecordingError, match=r"share/no_msgs/msg/Thing.msg not found; searched"):
        InstalledInterfaces().definition("no_msgs/msg/Thing")
    assert InstalledInterfaces().type_hash("no_msgs/msg/Thing") == ""


def test_the_first_prefix_wins(tmp_path):
    for prefix, text in (("one", "uint8 a\n"), ("two", "uint8 b\n")):
        folder = tmp_path / prefix / "share" / "p" / "msg"
        folder.mkdir(parents=True)
        (folder / "A.msg").write_text(text)
        hashes = [{"type_name": "p/msg/A", "hash_string": f"RIHS01_{prefix}"}]
        (folder / "A.json").write_text(json.dumps({"type_hashes": hashes}))
    installed = InstalledInterfaces([tmp_path / "one", tmp_path / "two"])
    assert installed.definition("p/A") == "uint8 a\n"
    assert installed.type_hash("p/A") == "RIHS01_one"
