"""Imports point down only, rooms stay apart, and each foreign library has its place.

docs/architecture.md draws the layers. Imports under TYPE_CHECKING count: what a type depends on is
known, whenever it is imported.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from blocked_imports import run_without

PACKAGE = "spacecraft_gnc"
ROOT = Path(__file__).resolve().parent.parent / PACKAGE
FILES = sorted(ROOT.rglob("*.py"))

LAYERS = (
    {"__init__", "errors", "extras", "arguments", "arrays", "lazy", "status"},
    {"_cached_kernels"},
    {"types", "_clock_kernels", "_kernels"},
    {"_inner_kernels"},
    {"solvability"},
    {"lie"},
    {"dynamics"},
    {"ocp"},
    {"governors"},
    {"parameters"},
    {"signals"},
    {"loop"},
    {"plant"},
    {"recording"},
    {"audit", "drawing"},
    {"vehicles"},
    {"scenario"},
    {"analysis"},
    {"campaign"},
    {"studies"},
    {"launcher", "ros"},
    {"nodes"},
    {"cli"},
    {"__main__"},
)
RANK = {name: rank for rank, layer in enumerate(LAYERS) for name in layer}
ROOMS = {path.parent.name for path in ROOT.glob("vehicles/*/__init__.py")}
MAY_IMPORT_ROOMS = {"vehicles", "studies"}

ROS = ("rclpy", "rcl_interfaces", "builtin_interfaces", "unique_identifier_msgs")
ROS_FILES = {"cli/inspect.py", "cli/slew.py"}


def is_ros(library: str) -> bool:
    return library in ROS or library.endswith("_msgs")


def may_import(path: str, library: str) -> bool:
    """Tell whether the file (relative to the package) may import a foreign library."""
    layer = path.split("/", maxsplit=1)[0]
    name = path.rsplit("/", 1)[-1]
    if is_ros(library):
        return layer in ("nodes", "ros") or path in ROS_FILES
    if library == "numba":
        return name.startswith("_") and name.endswith("kernels.py")
    if library in ("mcap", "rosbags", "mcap_ros2"):
        return layer in ("recording", "signals")
    if library in ("matplotlib", "plotly", "pyarrow", "foxglove"):
        return layer in ("analysis", "campaign", "drawing", "vehicles", "studies")
    if library == "casadi":
        return path in ("vehicles/two_wheel/ocp/nlp.py", "studies/phogat_ipopt.py")
    return library not in ("dask", "distributed") or layer == "campaign"


def imports(path: Path, source: str | None = None) -> Iterator[tuple[int, str]]:
    """Yield (line, absolute name) of everything that a file imports, for types only included."""
    package = [PACKAGE, *path.relative_to(ROOT).parts[:-1]]
    text = path.read_text(encoding="utf-8") if source is None else source
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*parents, *filter(None, [node.module])])
            yield from ((node.lineno, f"{module}.{alias.name}") for alias in node.names)


def layer_of(module: str) -> str:
    parts = module.split(".")
    known = len(parts) > 1 and parts[1] in RANK
    return parts[1] if known else "__init__"  # an attribute of the package itself


def room_of(module: str) -> str | None:
    """Return the vehicle whose room a module or file is in."""
    parts = module.split(".")
    return parts[2] if parts[1:2] == ["vehicles"] and len(parts) > 2 and parts[2] in ROOMS else None


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join((PACKAGE, *parts)).removesuffix(".__init__")


MODULES = {module_of(path): path for path in FILES}


def as_module(name: str) -> str | None:
    """Return the module of ours that an imported name is, or is in."""
    while name and name not in MODULES:
        name = name.rpartition(".")[0]
    return name or None


def complaints(path: Path, source: str | None = None) -> list[str]:
    """Return what a file imports and must not, one line each."""
    own, relative = module_of(path), path.relative_to(ROOT).as_posix()
    layer, room = relative.split("/")[0].removesuffix(".py"), room_of(own)
    found = []
    for line, name in imports(path, source):
        where = f"{relative}:{line} imports {name}"
        if name.split(".")[0] != PACKAGE:
            if not may_import(relative, name.split(".")[0]):
                found.append(f"{where}, which has no place here")
            continue
        theirs = room_of(name)
        if RANK[layer_of(name)] > RANK[layer]:
            found.append(f"{where}, which lies above it")
        if theirs and theirs != room and (room or layer not in MAY_IMPORT_ROOMS):
            found.append(f"{where}, a vehicle's room")
        if theirs and not room and layer == "vehicles":
            found.append(f"{where}, a vehicle's room")
        target = as_module(name)
        if target is None:
            continue
        folder, _, last = target.rpartition(".")
        own_folder = own if path.name == "__init__.py" else own.rpartition(".")[0]
        private = last.startswith("_") and not last.endswith("_kernels") and folder != PACKAGE
        if private and folder != own_folder:
            found.append(f"{where}, which is private to {folder}")
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_down_and_rooms_stay_apart(path: Path) -> None:
    layer = path.relative_to(ROOT).parts[0].removesuffix(".py")
    assert layer in RANK, f"{layer}: give it a place in LAYERS"
    assert complaints(path) == []


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Depth-first search; a package's own ``__init__`` only gathers names."""
    needs = {
        module: {
            target
            for _, name in imports(path)
            if (target := as_module(name)) not in (None, module, PACKAGE)
            and MODULES[target].name != "__init__.py"
        }
        for module, path in MODULES.items()
    }
    done: set[str] = set()

    def visit(module: str, way: tuple[str, ...]) -> None:
        assert module not in way, " imports ".join([*way[way.index(module) :], module])
        if module not in done:
            for other in sorted(needs[module]):
                visit(other, (*way, module))
            done.add(module)

    for module in needs:
        visit(module, ())


def test_the_rules_are_not_vacuous() -> None:
    assert not may_import("ocp/shooting.py", "numba")
    assert not may_import("loop/ladder.py", "rclpy")
    assert not may_import("cli/check.py", "spacecraft_gnc_msgs")
    assert not may_import("cli/plot.py", "matplotlib")
    assert not may_import("analysis/report/page.py", "rosbags")
    assert not may_import("cli/view.py", "foxglove")
    assert not may_import("cli/export.py", "pyarrow")
    seen = {module for path in FILES for _, module in imports(path)}
    assert {"numba", "rclpy"} <= {module.split(".")[0] for module in seen}
    assert any(name.startswith(f"{PACKAGE}.types.") for name in seen)
    assert "rigid_body" in ROOMS


@pytest.mark.parametrize(
    ("file", "source", "reason"),
    [
        ("ocp/shooting.py", "from spacecraft_gnc.scenario import Scenario", "lies above it"),
        (
            "ocp/shooting.py",
            "if TYPE_CHECKING:\n    from spacecraft_gnc.scenario import Scenario",
            "lies above it",
        ),
        ("scenario/load.py", "import spacecraft_gnc.vehicles.rigid_body", "a vehicle's room"),
        ("scenario/load.py", "from spacecraft_gnc.vehicles import rigid_body", "a vehicle's room"),
        (
            "vehicles/registry.py",
            "from spacecraft_gnc.vehicles.rigid_body import VEHICLE",
            "a vehicle's room",
        ),
        ("cli/main.py", "from spacecraft_gnc.nodes._node import GncNode", "private to"),
    ],
)
def test_a_wrong_import_is_refused(file: str, source: str, reason: str) -> None:
    found = complaints(ROOT / file, source)
    assert len(found) == 1, found
    assert reason in found[0]


def test_everything_below_ros_imports_without_ros() -> None:
    above = ("nodes", "ros", "launcher")
    modules = [
        module
        for module, path in MODULES.items()
        if path.relative_to(ROOT).parts[0] not in above and path.name != "__main__.py"
    ]
    assert len(modules) > 20
    code = f"import importlib\nfor name in {modules!r}: importlib.import_module(name)\nprint('ok')"
    result = run_without((*ROS, "_msgs"), code)
    assert result.stdout == "ok\n", result.stderr


def test_check_needs_neither_ros_nor_kernels() -> None:
    code = (
        "from spacecraft_gnc.cli.main import main\nmain(['check', 'config/gupta2015_case1.yaml'])\n"
    )
    blocked = (
        *ROS,
        "_msgs",
        "numba",
        "scipy",
        "mcap",
        "rosbags",
        "matplotlib",
        "plotly",
        "pyarrow",
    )
    result = run_without(blocked, code)
    assert result.returncode == 0, result.stderr
    assert "can fly" in result.stdout
