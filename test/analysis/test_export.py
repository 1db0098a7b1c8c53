"""What is exported comes back bit for bit, in readers that know nothing of this package."""

from __future__ import annotations

import csv
import json
import math
import sys
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from recording.bags import CODEC, STANDARD, flight_messages, random_flight, record
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.io import loadmat

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.export import SUFFIXES, read_export, write_export
from spacecraft_gnc.analysis.export.field_text import field_texts
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.schema_text import schema_text
from spacecraft_gnc.recording.writer import BagWriter

STEPS = 9
TINY = 5e-324  # the smallest double: lost by every format with fewer than 17 digits
LOST = ("torque_command", 4)
NO_SOLVE = 6  # step without a solve: NaN, which is a value and not a missing one


def flight():
    """Return a flight with numbers that are hard to write."""
    found = random_flight(STEPS, seed=7)
    torque = found.torque.copy()
    torque[0] = [0.1 + 0.2, -0.0, TINY]
    torque[1] = [1.7976931348623157e308, 1.0 / 3.0, math.pi]
    residual = found.residual.copy()
    residual[NO_SOLVE] = math.nan
    return replace(found, torque=torque, residual=residual)


FLIGHT = flight()


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    items = []
    no_solve = CODEC.status(NO_SOLVE, 0, math.nan, math.nan, math.nan, status=255)
    for item in flight_messages(FLIGHT):
        if item[:2] == ("solver_status", NO_SOLVE):
            items.append(("solver_status", NO_SOLVE, no_solve))
        elif item[:2] != LOST:
            items.append(item)
    return record(tmp_path_factory.mktemp("export") / "bag", items)


@pytest.fixture
def exported(bag, tmp_path):
    """Return a function that writes a format and returns the file."""

    def write(kind):
        write_export(read_export(bag), tmp_path / f"run.{kind}", kind)
        return tmp_path / f"run.{kind}"

    return write


def bits(values):
    return np.array(list(values), dtype="<f8").view("<u8").tolist()


def columns_of(kind, file):
    """Return {column: list of cells} as an independent reader of a table has them."""
    if kind == "parquet":
        return pq.read_table(file).to_pydict()
    with file.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {name: [row[name] for row in rows] for name in rows[0]}


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_a_table_holds_every_double_bit_for_bit(exported, kind):
    table = columns_of(kind, exported(kind))
    momentum = [*FLIGHT.momentum, FLIGHT.final_momentum]
    attitude = [*FLIGHT.attitude, FLIGHT.final_attitude]
    assert [int(step) for step in table["step"]] == list(range(STEPS + 1))
    for i, part in enumerate("xyz"):
        column = [float(cell) for cell in table[f"attitude_state.angular_momentum.{part}"]]
        assert bits(column) == bits([row[i] for row in momentum])
        applied = [float(cell) for cell in table[f"plant_invariants.applied_torque.{part}"]]
        assert bits(applied[1:]) == bits(FLIGHT.torque[:, i])
    for i in range(9):
        column = [float(cell) for cell in table[f"attitude_state.attitude.{i}"]]
        assert bits(column) == bits([row.ravel()[i] for row in attitude])
    for i, part in enumerate("xyzw"):
        column = [float(cell) for cell in table[f"attitude_state.orientation.{part}"]]
        assert bits(column) == bits([lie.to_quaternion_xyzw(row)[i] for row in attitude])


@pytest.mark.parametrize(("kind", "absent"), [("csv", ""), ("parquet", None)])
def test_a_table_tells_missing_from_nan_and_keeps_integers(exported, kind, absent):
    table = columns_of(kind, exported(kind))
    torque = table["torque_command.torque.y"]
    assert [step for step, cell in enumerate(torque) if cell == absent] == [LOST[1], STEPS]
    residual = table["solver_status.residual"]
    assert math.isnan(float(residual[NO_SOLVE]))
    assert bits(float(cell) for cell in residual[:NO_SOLVE]) == bits(FLIGHT.residual[:NO_SOLVE])
    source = table["torque_command.source"]
    kept = [None if cell == absent else cell for cell in source]
    expected = [None if k in (LOST[1], STEPS) else int(FLIGHT.source[min(k, STEPS - 1)])
                for k in range(STEPS + 1)]  # fmt: skip
    assert kept == [None if e is None else (str(e) if kind == "csv" else e) for e in expected]
    assert table["solver_status.method"][0] == "shooting"
    assert str(table["governor_status.admissible"][0]) == ("1" if kind == "csv" else "True")


def test_npz_holds_every_double_bit_for_bit(exported):
    with np.load(exported("npz"), allow_pickle=False) as stored:
        assert_arrays(lambda topic, field: stored[f"{topic}.{field}"])
        units = {name: unit for name, unit, _ in stored["columns"]}
        assert stored["solver_status.method"].tolist() == ["shooting"] * STEPS
    assert units["attitude_state.angular_momentum"] == "N m s"


def test_mat_holds_every_double_bit_for_bit(exported):
    stored = loadmat(exported("mat"), squeeze_me=False, struct_as_record=True)
    assert_arrays(lambda topic, field: stored[topic][field][0, 0], column=True)
    assert stored["units"]["attitude_state"][0, 0]["angular_momentum"][0, 0][0] == "N m s"
    assert [row[0][0] for row in stored["solver_status"]["method"][0, 0]] == ["shooting"] * STEPS
    names = [name for name in stored if not name.startswith("__")]
    names += [field for name in names for field in stored[name].dtype.names]
    assert max(map(len, names)) <= 31
    assert all(name.isidentifier() for name in names)


def assert_arrays(array, *, column=False):
    """Compare what a file of arrays holds with the flight that was recorded."""
    shape = (-1, 1) if column else (-1,)
    torque = np.delete(FLIGHT.torque, LOST[1], axis=0)
    assert bits(array("torque_command", "torque")) == bits(torque)
    assert bits(array("attitude_state", "attitude")[:-1]) == bits(FLIGHT.attitude.reshape(-1, 9))
    residual = array("solver_status", "residual")
    assert residual.shape == np.zeros(STEPS).reshape(shape).shape
    expected = FLIGHT.residual.reshape(shape)
    assert np.isnan(residual[NO_SOLVE])
    assert bits(residual[:NO_SOLVE]) == bits(expected[:NO_SOLVE])
    source = array("torque_command", "source")
    assert source.dtype == np.int64
    np.testing.assert_array_equal(source.ravel(), np.delete(FLIGHT.source, LOST[1]))
    steps = [k for k in range(STEPS) if k != LOST[1]]
    assert array("torque_command", "step").ravel().tolist() == steps


def test_every_column_of_a_table_has_a_unit(exported):
    table = columns_of("csv", exported("csv"))
    units = columns_of("csv", exported("csv").with_name("run.columns.csv"))
    assert units["column"] == list(table)
    texts = {"solver_status.method", "solver_status.formulation", "solver_status.active_constraint",
             "governor_status.active_constraint", "governor_status.admissible",
             "governor_status.margin"}  # fmt: skip
    without = {n for n, unit in zip(units["column"], units["unit"], strict=True) if not unit}
    assert without <= texts
    schema = pq.read_schema(exported("parquet"))
    field = schema.field("torque_command.torque.x")
    assert field.metadata[b"unit"] == b"N m"
    assert b"body frame" in field.metadata[b"description"]


def test_the_comments_of_a_definition_are_read():
    text = "# About.\nuint8 A=0  # no field\nstd_msgs/Header header  # stamp [s]\n\
float64[] plan  # 3N: torques [N m]\nstring name\ngeometry_msgs/Quaternion q  # x [-], y [deg]\n"
    found = field_texts(f"{text}{'=' * 80}\nMSG: other/Type\nfloat64 inner  # [m]\n")
    assert set(found) == {"header", "plan", "name", "q"}
    assert found["plan"].unit == "N m"
    assert found["name"] == ("", "", "")
    assert found["q"][::2] == ("-", "xyzw")


def run(*arguments):
    """Run ``gnc export`` and return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(["export", *map(str, arguments)])
    return ended.value.code or 0


@pytest.mark.parametrize("kind", SUFFIXES)
def test_the_command_names_what_it_wrote(bag, tmp_path, monkeypatch, capsys, kind):
    monkeypatch.chdir(tmp_path)
    assert run(bag, "--format", kind, "--topics", "torque_command", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["topics"] == {"torque_command": STEPS - 1}
    expected = {f"bag.{kind}"}
    expected |= {"bag.columns.csv"} if kind == "csv" else set()
    assert {path.name for path in tmp_path.iterdir()} == set(answer["files"]) == expected


def test_an_existing_file_is_kept_unless_forced(bag, tmp_path, capsys):
    out = tmp_path / "kept.csv"
    out.write_text("mine")
    assert run(bag, "-f", "csv", "-o", out) == 2
    assert "which exists" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["kept.csv"]
    assert run(bag, "-f", "csv", "-o", out, "--force") == 0
    assert out.read_text().startswith("step,")


def test_an_unknown_topic_is_refused_with_those_there_are(bag, tmp_path, capsys):
    assert run(bag, "-f", "npz", "-o", tmp_path / "x.npz", "--topics", "clock") == 2
    error = capsys.readouterr().err
    assert "received 'clock'" in error
    assert "attitude_state" in error
    assert not list(tmp_path.iterdir())


def test_without_pyarrow_one_line_says_what_to_install(bag, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert run(bag, "-f", "parquet", "-o", tmp_path / "x.parquet") == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    assert len(lines) == 1
    assert "pip install 'spacecraft_gnc[export]'" in lines[0]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", SUFFIXES)
def test_a_write_that_fails_leaves_nothing(bag, tmp_path, monkeypatch, kind):
    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.replace", fail)
    with pytest.raises(RecordingError, match="No space left"):
        write_export(read_export(bag), tmp_path / f"x.{kind}", kind)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("none/x.mat", "in a folder that does not exist"),
        ("x.csv", "no .mat file"),
        ("", "no .mat file"),
        (".", "no .mat file"),
    ],
)
def test_a_file_that_cannot_be_is_refused_before_anything_is_read(
    tmp_path, capsys, monkeypatch, name, reason
):
    monkeypatch.chdir(tmp_path)
    assert run(tmp_path / "no bag", "-f", "mat", "-o", name) == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert f"{reason}; required a .mat file in a writable folder; " in error
    assert list(tmp_path.iterdir()) == []


def test_a_bag_of_a_vehicle_that_is_not_installed(tmp_path):
    text = "std_msgs/Header header\nuint64 step\nfloat64 height  # above ground [m]\nstring mood\n"
    name = "hopper_msgs/msg/HopperState"
    definition = schema_text(name, lambda kind: text if kind == name else STANDARD[kind])
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, name))
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/hopper_state", name, definition)
        for step in range(3):
            header = CODEC.header(step)
            message = store.types[name](header=header, step=step, height=0.5 * step, mood="ok")
            bag.write("/hopper_state", step, step, bytes(store.serialize_cdr(message, name)))
    (topic,) = read_export(tmp_path / "bag").topics
    assert topic.name == "hopper_state"
    fields = {field.name: field for field in topic.fields}
    assert fields["height"].values.tolist() == [0.0, 0.5, 1.0]
    assert fields["height"].text.unit == "m"
    with pytest.raises(RecordingError, match=r"no topic .*attitude_state"):
        read_flight(tmp_path / "bag")
