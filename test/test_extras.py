"""Commands in an environment without ROS 2, or without another extra of the package."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from blocked_imports import run_without
from recording.bags import flight_messages, random_flight, record

from spacecraft_gnc import __main__ as scripts
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.extras import MissingDependency, explained_imports

CASE1 = str(Path(__file__).parents[1] / "config" / "gupta2015_case1.yaml")
NEEDS_ROS = "error: the node graph needs ROS 2: pip install 'spacecraft_gnc[ros]'"
NO_RCLPY = f"{NEEDS_ROS} (there is no module 'rclpy')\n"
SLEW = ("slew", "--axis", "0", "0", "1", "--angle-deg", "10")
NODES = ("plant", "nmpc_controller", "reference_governor", "recorder")
LIVE = (
    ("launch", CASE1),
    ("bench", "--no-peers", "--quiet"),
    SLEW,
    ("view", "--no-browser"),
    ("view", "--foxglove"),
    ("inspect", "nodes"),
    ("inspect", "topics", "--rates"),
    ("inspect", "echo", "attitude_state"),
    ("inspect", "hz", "attitude_state"),
    ("inspect", "delay", "attitude_state"),
    ("inspect", "lifecycle", "plant"),
    ("inspect", "params", "list", "plant"),
    ("inspect", "watch", "--once"),
)


def hide(monkeypatch: pytest.MonkeyPatch, module: str) -> None:
    """Let imports of a module fail, and forget what has imported it already."""
    monkeypatch.setitem(sys.modules, module, None)
    for name in [n for n in sys.modules if n.startswith(("spacecraft_gnc.nodes", f"{module}."))]:
        monkeypatch.delitem(sys.modules, name)


def run(capsys: pytest.CaptureFixture[str], *argv: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(argv)
    captured = capsys.readouterr()
    return int(end.value.code or 0), captured.out, captured.err


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory, and no graph in sight."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    monkeypatch.setenv("ROS_DOMAIN_ID", "0")
    return folder


@pytest.mark.parametrize("argv", LIVE, ids=" ".join)
def test_what_talks_to_a_graph_says_that_it_needs_ros(
    argv: tuple[str, ...], elsewhere: Path, capsys, monkeypatch
) -> None:
    hide(monkeypatch, "rclpy")
    assert run(capsys, *argv) == (2, "", NO_RCLPY)
    assert not any(elsewhere.iterdir())


def test_a_bag_is_not_published_without_ros(elsewhere: Path, tmp_path, capsys, monkeypatch) -> None:
    bag = record(tmp_path / "bag", flight_messages(random_flight(3)))
    hide(monkeypatch, "rclpy")
    assert run(capsys, "replay", str(bag), "--publish") == (2, "", NO_RCLPY)


@pytest.mark.parametrize("node", NODES)
def test_a_node_says_that_it_needs_ros(node: str, capsys, monkeypatch) -> None:
    hide(monkeypatch, "rclpy")
    assert getattr(scripts, node)() == 2
    assert capsys.readouterr() == ("", NO_RCLPY)


@pytest.mark.parametrize("argv", [("launch", CASE1), SLEW], ids=" ".join)
def test_messages_that_are_not_built_have_a_line_of_their_own(
    argv: tuple[str, ...], elsewhere: Path, capsys, monkeypatch
) -> None:
    hide(monkeypatch, "spacecraft_gnc_msgs")
    code, out, err = run(capsys, *argv)
    assert (code, out) == (2, "")
    assert err.startswith("error: the node graph needs its messages built: run `make setup` in a ")
    assert err.endswith(" (there is no module 'spacecraft_gnc_msgs')\n")
    assert err.count("\n") == 1
    assert not any(elsewhere.iterdir())


def test_a_message_package_of_ros_counts_as_ros() -> None:
    with pytest.raises(MissingDependency, match="needs ROS 2") as caught, explained_imports():
        import nowhere_msgs.msg  # noqa: F401
    assert caught.value.name == "nowhere_msgs"


def test_a_module_of_nobody_keeps_its_traceback() -> None:
    with pytest.raises(ModuleNotFoundError) as caught, explained_imports():
        import nowhere  # noqa: F401
    assert not isinstance(caught.value, MissingDependency)


def test_a_launch_in_a_process_that_cannot_import_ros() -> None:
    blocked = ("rclpy", "rcl_interfaces", "builtin_interfaces", "_msgs")
    call = f"from spacecraft_gnc.cli.main import main\nmain(['launch', {CASE1!r}])"
    result = run_without(blocked, call)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr == f"{NEEDS_ROS} (there is no module 'rclpy')\n"


def test_a_node_in_a_process_that_cannot_import_ros() -> None:
    blocked = ("rclpy", "rcl_interfaces", "builtin_interfaces", "_msgs")
    result = run_without(blocked, "from spacecraft_gnc.__main__ import plant\nsys.exit(plant())")
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith(NEEDS_ROS)
    assert result.stderr.count("\n") == 1
