"""Invalid bags: one list of cases for every command that reads a bag.

Test a command with all of them as follows (see ``test/cli/test_bad_bags.py``)::

    @pytest.mark.parametrize("name", CASES)
    def test_refused(name, tmp_path, capsys):
        check_refused(CASES[name], tmp_path, capsys, "audit")
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from recording.bags import CODEC, TOPICS, announce, flight_messages, random_flight, record

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.recording.writer import BagWriter

FLIGHT = random_flight(12)
ITEMS = flight_messages(FLIGHT)
STATE_TYPE = "spacecraft_gnc_msgs/msg/AttitudeState"
TEXT = b"\0\1\0\0\2\0\0\0a\0"  # a std_msgs/String


class BadBag(NamedTuple):
    make: Callable[[Path], Path]
    """Makes the bag in a folder, and returns what the user would name."""
    received: str
    """Words of the line, before what is required."""
    required: str


def refused_line(error: str, path: Path, case: BadBag) -> None:
    """Check that a message is one line with path, received value and requirement."""
    assert len(error.splitlines()) == 1, error
    assert str(path) in error
    received, required, rest = error.partition("; required ")
    assert case.received in received, error
    assert required, error
    assert case.required in rest, error
    assert ";" in rest, f"no remedy: {error}"


def check_refused(
    case: BadBag, folder: Path, capsys: pytest.CaptureFixture[str], *command: str
) -> None:
    """Check that ``gnc COMMAND BAG`` ends with one line and exit code 2, and leaves no files."""
    path = case.make(folder)
    before = sorted(folder.rglob("*"))
    with pytest.raises(SystemExit) as ended:
        main([*command, str(path)])
    captured = capsys.readouterr()
    assert (ended.value.code, captured.out) == (2, ""), captured.err
    assert "Traceback" not in captured.err
    # a slow machine may report progress first
    (error,) = [line for line in captured.err.splitlines() if line.startswith("error: ")]
    refused_line(error.removeprefix("error: "), path, case)
    assert sorted(folder.rglob("*")) == before


def _bag(items: list[tuple[str, int, bytes]]) -> Callable[[Path], Path]:
    return lambda folder: record(folder / "bag", items)


def _replaced(topic: str, step: int, data: bytes) -> Callable[[Path], Path]:
    """Return a maker of the valid bag with one message replaced."""
    assert (topic, step) in [item[:2] for item in ITEMS]
    return _bag([(t, k, data if (t, k) == (topic, step) else old) for t, k, old in ITEMS])


def _edited(topic: str, at: int, **values: object) -> Callable[[Path], Path]:
    """Return a maker of the valid bag with fields of one message changed."""
    name = f"spacecraft_gnc_msgs/msg/{TOPICS[topic]}"
    (data,) = (item[2] for item in ITEMS if item[:2] == (topic, at))
    message = CODEC.store.deserialize_cdr(data, name)
    for key, value in values.items():
        setattr(message, key, value)
    return _replaced(topic, at, bytes(CODEC.store.serialize_cdr(message, name)))


def _file(name: str, data: bytes) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return make


def _folder(name: str, *files: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        (folder / name).mkdir()
        for file in files:
            (folder / name / file).write_text("")
        return folder / name

    return make


def _folders(folder: Path) -> Path:
    (folder / "bag" / "bag_0.mcap").mkdir(parents=True)
    return folder / "bag"


def _closed(folder: Path) -> Path:
    BagWriter(folder / "bag").close()
    return folder / "bag"


def _chatter(topic: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        with BagWriter(folder / "bag") as bag:
            bag.add_topic(topic, "std_msgs/msg/String", "string data")
            bag.write(topic, 0, 0, TEXT)
        return folder / "bag"

    return make


def _version(text: str, data: bytes, type_hash: str = "") -> Callable[[Path], Path]:
    """Return a maker of a bag whose states have another message definition."""

    def make(folder: Path) -> Path:
        with BagWriter(folder / "bag") as bag:
            bag.add_topic("/attitude_state", STATE_TYPE, text, type_hash=type_hash)
            bag.write("/attitude_state", 0, 0, data)
        return folder / "bag"

    return make


def _cut(share: float) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        whole = record(folder / "bag", ITEMS, chunk_size=1500) / "bag_0.mcap"
        data = whole.read_bytes()
        whole.write_bytes(data[: int(share * len(data))])
        return folder / "bag"

    return make


def _killed(folder: Path) -> Path:
    bag = record(folder / "bag", ITEMS)
    (bag / "metadata.yaml").unlink()
    return bag


def _damaged(folder: Path) -> Path:
    """Flip a bit of a message, behind all headers that a reader checks first."""
    bag = record(folder / "bag", ITEMS, compression="none")
    data = bytearray((bag / "bag_0.mcap").read_bytes())
    place = data.index(np.ascontiguousarray(FLIGHT.attitude[5]).tobytes())
    data[place] ^= 1
    (bag / "bag_0.mcap").write_bytes(data)
    return bag


def _two_spacecraft(folder: Path) -> Path:
    with BagWriter(folder / "bag") as bag:
        for name in ("/chaser", "/target"):
            announce(bag, name)
            for topic, step, data in ITEMS:
                bag.write(f"{name}/{topic}", step, step, data)
    return folder / "bag"


_TEXT = CODEC.texts[STATE_TYPE]
_STATE = CODEC.state(0, np.eye(3), np.zeros(3))
_OTHER = flight_messages(random_flight(12, seed=9))
_NAN = float("nan")
_MOMENTUM = CODEC.vector([0.0, _NAN, 0.0])

CASES = {
    "no bag at all": BadBag(lambda folder: folder / "none", "no such file", "a bag folder"),
    "no bag of that name": BadBag(lambda folder: folder / "none.mcap", "no such file", "a bag"),
    "a directory without a bag": BadBag(
        _folder("notes", "a.txt"), "a folder without a bag", "a bag folder"
    ),
    "an empty directory": BadBag(_folder("out"), "a folder without a bag", "a bag folder"),
    "a directory called like a file": BadBag(
        _folder("bag.mcap"), "a folder without a bag", "a bag folder"
    ),
    "a directory in the place of the file": BadBag(
        _folders,
        "cannot be read", "a bag folder",
    ),
    "another kind of file": BadBag(_file("a.csv", b"1,2"), "another kind of file", "a bag folder"),
    "a file that is not MCAP": BadBag(_file("a.mcap", b"1,2,3,4,5,6,7"), "not MCAP", "a bag"),
    "an empty file": BadBag(_file("a.mcap", b""), "an empty file", "a bag folder"),
    "an empty bag": BadBag(
        lambda folder: record(folder / "bag", []), "0 states and 0 torques", "one whole control",
    ),
    "a bag without topics": BadBag(
        _closed, "attitude_state or wheel_state", "a flight recorded by"
    ),
    "a bag without a whole step": BadBag(_bag(ITEMS[:5]), "states and", "one whole control step"),
    "a bag without torques": BadBag(
        _bag([item for item in ITEMS if item[0] == "attitude_state"]),
        "13 states and 0 torques", "one whole control step",
    ),
    "a bag cut off": BadBag(_cut(0.6), "an unfinished bag", "a closed one"),
    "a bag cut off at its end": BadBag(_cut(0.999), "an unfinished bag", "a closed one"),
    "a bag whose recorder was killed": BadBag(_killed, "an unfinished bag", "a closed one"),
    "a damaged bag": BadBag(_damaged, "cannot be read as a ROS 2 bag", "intact"),
    "a bag of another package": BadBag(
        _chatter("/chatter"), "attitude_state or wheel_state", "a flight recorded by spacecraft_gnc"
    ),
    "a topic of another package": BadBag(
        _chatter("/attitude_state"), "has type std_msgs/msg/String", STATE_TYPE
    ),
    "another version of a message": BadBag(
        _version(_TEXT.replace("angular_velocity", "body_rate", 1), _STATE),
        "/attitude_state: received spacecraft_gnc_msgs/msg/AttitudeState with type hash RIHS01_",
        "RIHS01_1e8805516c0c5a75a2ad9192a0d5f9d4db16bb73fd628ea1199be42b0d2721c1",
    ),
    "a message of nothing we know": BadBag(
        _version("uint64 count\n", b"\0\1\0\0" + bytes(8)), "with type hash RIHS01_", "RIHS01_1e88"
    ),
    "a definition that does not fit its hash": BadBag(
        _version(_TEXT, _STATE, "RIHS01_0"), "hash mismatch", "intact"
    ),
    "a message shorter than its definition": BadBag(
        _version(_TEXT, _STATE[:99]), "/attitude_state: received a message of 99 bytes", "at least"
    ),
    "NaN in a state": BadBag(
        _edited("attitude_state", 5, angular_momentum=_MOMENTUM),
        "/attitude_state, step 5, field angular_momentum: received nan at [1]", "finite",
    ),
    "NaN in a rotation": BadBag(
        _edited("attitude_state", 0, attitude=np.full(9, _NAN)),
        "/attitude_state, step 0, field attitude: received nan", "finite",
    ),
    "infinity in a torque": BadBag(
        _replaced("torque_command", 7, CODEC.torque(7, [0.0, 0.0, -np.inf])),
        "/torque_command, step 7, field torque: received -inf at [2]", "finite",
    ),
    "NaN in an applied torque": BadBag(
        _replaced("plant_invariants", 3, CODEC.invariants(3, [_NAN, 0.0, 0.0])),
        "/plant_invariants, step 3, field applied_torque: received nan", "finite",
    ),
    "NaN in the plan of a converged solve": BadBag(
        _edited("solver_status", 4, predicted_torques=np.array([0.0, _NAN])),
        "/solver_status, step 4, field predicted_torques: received nan at [1]", "finite",
    ),
    "NaN in a governor's decision": BadBag(
        _replaced("governor_status", 2, CODEC.decision(2, _NAN, 1.0)),
        "/governor_status, step 2, field alpha: received nan", "finite",
    ),
    "two runs": BadBag(
        _bag(ITEMS + _OTHER), "two different messages of step 0", "one run of one spacecraft"
    ),
    "two runs that are the same": BadBag(
        _bag(ITEMS + ITEMS), "step 0 again after step 12", "one run of one spacecraft"
    ),
    "two spacecraft": BadBag(_two_spacecraft, "several spacecraft (/chaser, /target)", "one"),
    "a step number out of reach": BadBag(
        _edited("attitude_state", 12, step=2**40),
        "at step 1099511627776", "at least every",
    ),
    "a step number that no count reaches": BadBag(
        _edited("torque_command", 3, step=2**63),
        "/torque_command: received step 9223372036854775808", "below",
    ),
}  # fmt: skip
