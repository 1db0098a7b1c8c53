"""``gnc view`` as a command: what it says, refuses and warns of."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from analysis.flights import case1
from bad_bags import CASES
from live.watching import EventReader

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 60.0  # [s] wall


@pytest.fixture
def flight(tmp_path: Path) -> Path:
    file = tmp_path / "flight.npz"
    case1().save(file)
    return file


def command(*argv: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "spacecraft_gnc", "view", *argv],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def refused(*argv: str) -> tuple[int, str]:
    """Return exit code and the one line of a refusal."""
    with command(*argv) as process:
        out, err = process.communicate(timeout=PATIENCE)
    assert out == ""
    (line,) = err.splitlines()
    return process.returncode, line


@contextmanager
def viewing(*argv: str) -> Iterator[dict]:
    """Yield what a running view says of itself; Ctrl-C must end it well."""
    with command(*argv, "--json") as process:
        text = ""
        while not text.endswith("}\n"):
            line = process.stdout.readline()
            assert line, process.stderr.read()
            text += line
        about = json.loads(text)
        yield about
        process.send_signal(signal.SIGINT)
        out, about["err"] = process.communicate(timeout=PATIENCE)
        assert (process.returncode, out) == (0, "")


def test_a_recording_plays_and_ctrl_c_ends_it(flight: Path) -> None:
    with viewing(str(flight), "--rate", "1000") as about:
        assert about["url"] == f"http://127.0.0.1:{about['port']}/"
        reader = EventReader(about["port"])
        last = next(data for name, data in reader if name == "frame" and data["phase"] == "over")
        reader.close()
    assert last["step"] == 374
    assert about["err"] == ""


def test_of_several_spacecraft_the_first_is_shown(tmp_path: Path) -> None:
    bag = str(CASES["two spacecraft"].make(tmp_path))
    for words, shown, said in (([], "chaser", 1), (["--namespace", "target"], "target", 0)):
        with viewing(bag, *words) as about:
            reader = EventReader(about["port"])
            title = next(data["title"] for name, data in reader if name == "setup")
            reader.close()
        assert title == f"bag /{shown}"
        told = [line for line in about["err"].splitlines() if "several spacecraft" in line]
        assert len(told) == said
        assert all("(/chaser, /target); shows the first; name another" in line for line in told)


def test_a_port_that_is_taken_is_refused_in_one_line(flight: Path) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        code, line = refused(str(flight), "--port", str(port), "--no-browser")
    assert code == 2
    assert line.startswith(f"error: --port: received {port}, where another process listens")
    assert "choose another, or leave --port out" in line


def test_to_be_seen_from_elsewhere_is_warned_of(flight: Path) -> None:
    with viewing(str(flight), "--host", "0.0.0.0") as about:
        pass
    (line,) = about["err"].splitlines()
    assert line.startswith("warning: --host 0.0.0.0: everybody who reaches this machine")


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("nothing_here",), "no such file or folder"),
        (("--rate", "2"), "--rate: received a rate for a live graph"),
        (("FLIGHT", "--rate", "0"), "rate: received 0.0"),
        (("FLIGHT", "--rate", "nan"), "rate: received nan"),
        (("FLIGHT", "--host", "192.0.2.7"), "--host: received '192.0.2.7'"),
        (("FLIGHT", "--foxglove"), "received another kind of file"),
    ],
)
def test_what_cannot_be_viewed_is_refused(flight: Path, argv: tuple[str, ...], words: str) -> None:
    given = [str(flight) if word == "FLIGHT" else word for word in argv]
    answer = command(*given, "--no-browser", "--quiet")
    with answer as process:
        out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out) == (2, "")
    errors = [line for line in err.splitlines() if not line.startswith("warning: ")]
    assert len(errors) == 1
    assert words in errors[0]
