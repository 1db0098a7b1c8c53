"""Every signal is what its .msg file says."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_typestore

from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.signal import STEPPED, Signal
from spacecraft_gnc.signals.structures import STRUCTURES, parse_kind
from spacecraft_gnc.signals.type_hash import type_hash
from spacecraft_gnc.vehicles.registry import VEHICLES, own_names, vehicle_of

MESSAGES = Path(__file__).parents[2] / "msg_defs" / "msg"
FIELD = re.compile(r"^(\S+)\s+([a-z]\w*)\s*(?:#.*?(?:\[(.*?)\]|$))?")
ROOMS = [vehicle_of(name).signals.load() for name in own_names(VEHICLES)]
EVERY = tuple(dict.fromkeys([*graph.SIGNALS, *(signal for room in ROOMS for signal in room)]))
OURS = [signal for signal in EVERY if signal.type.startswith("spacecraft_gnc_msgs/")]


def installed(type_name: str, suffix: str) -> Path:
    package, kind, leaf = type_name.split("/")
    path = Path(sys.prefix, "share", package, kind, leaf + suffix)
    if not path.exists():
        pytest.skip("the messages are not installed")
    return path


def declared(path: Path) -> list[tuple[str, str, str]]:
    """Return (name, type, unit) of the fields in a .msg file."""
    lines = (line for line in path.read_text().splitlines() if "=" not in line.split("#")[0])
    found = (FIELD.match(line) for line in lines if not line.startswith("#"))
    return [(match[2], match[1], match[3] or "") for match in found if match]


@pytest.mark.parametrize("signal", OURS, ids=str)
def test_fields_types_order_and_units_are_those_of_the_file(signal: Signal) -> None:
    header, step, *fields = declared(MESSAGES / f"{signal.type.rpartition('/')[2]}.msg")
    assert (header[:2], step[:2]) == (("header", "std_msgs/Header"), ("step", "uint64"))
    assert signal.start == STEPPED
    assert fields == [(name, field.kind, field.unit) for name, field in signal.fields.items()]


@pytest.mark.parametrize("signal", OURS, ids=str)
def test_the_frame_is_that_of_the_file(signal: Signal) -> None:
    text = (MESSAGES / f"{signal.type.rpartition('/')[2]}.msg").read_text()
    told = re.search(r"frame_id: (?:\"(\w+)\"|empty)", text)
    assert told is not None
    assert signal.frame == (told[1] or "")


def test_no_file_is_without_a_signal() -> None:
    types = {signal.type.rpartition("/")[2] for signal in OURS}
    assert types == {path.stem for path in MESSAGES.glob("*.msg")}


def test_names_are_unique() -> None:
    names = [signal.name for signal in EVERY]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("signal", EVERY, ids=str)
def test_the_hash_is_that_of_the_installed_message(signal: Signal) -> None:
    described = installed(signal.type, ".json").read_text()
    assert f'"hash_string": "{signal.type_hash}"' in described


STORE = get_typestore(Stores.ROS2_JAZZY)


@pytest.mark.parametrize("name", STRUCTURES)
def test_standard_structures_and_their_hashes_are_those_of_jazzy(name: str) -> None:
    full = name.replace("/", "/msg/")
    fields = [field for field, _ in STORE.fielddefs[full][1]]
    assert fields == list(STRUCTURES[name])
    assert type_hash(full, STRUCTURES[name]) == STORE.hash_rihs01(full)


def test_a_package_that_is_not_known_is_refused() -> None:
    with pytest.raises(ValueError, match="required one of bool"):
        parse_kind("Vector3")
