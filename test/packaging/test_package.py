"""The package as it is installed: names, versions and files that must agree."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

import spacecraft_gnc
from spacecraft_gnc.vehicles import registry

ROOT = Path(__file__).parents[2]
SOURCES = (
    "README.md",
    "setup.py",
    "setup.cfg",
    "pyproject.toml",
    "package.xml",
    "requirements.lock",
)
SOURCE_FOLDERS = ("config", "resource", "spacecraft_gnc")


@pytest.fixture(scope="module")
def wheel_files(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """Files of the wheel that `pip install .` installs; built from a copy to leave no traces."""
    tree, output = tmp_path_factory.mktemp("tree"), tmp_path_factory.mktemp("wheel")
    for name in SOURCES:
        shutil.copy(ROOT / name, tree)
    for name in SOURCE_FOLDERS:
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
    build = ["-m", "pip", "wheel", "-qq", "--no-deps", "--no-build-isolation", "-w", output, tree]
    subprocess.run([sys.executable, *build], check=True)
    (wheel,) = output.iterdir()
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_versions_agree() -> None:
    manifests = [ET.parse(ROOT / p) for p in ("package.xml", "msg_defs/package.xml")]
    versions = {manifest.findtext("version") for manifest in manifests}
    assert versions == {spacecraft_gnc.__version__}


def test_every_folder_of_vehicles_is_a_vehicle() -> None:
    folders = {p.parent.name for p in (ROOT / "spacecraft_gnc/vehicles").glob("*/descriptor.py")}
    assert folders == set(registry.own_names(registry.VEHICLES))
    for name in folders:
        assert registry.vehicle_of(name).name == name


@pytest.mark.parametrize(
    "script", ["gnc", "plant", "nmpc_controller", "reference_governor", "recorder"]
)
def test_console_script_leads_to_a_function(script: str) -> None:
    (entry,) = metadata.entry_points(group="console_scripts", name=script)
    assert callable(entry.load())


def test_wheel_holds_every_module(wheel_files: set[str]) -> None:
    modules = {str(p.relative_to(ROOT)) for p in (ROOT / "spacecraft_gnc").rglob("*.py")}
    assert modules <= wheel_files


def test_wheel_holds_every_data_file(wheel_files: set[str]) -> None:
    data = {
        str(path.relative_to(ROOT))
        for path in (ROOT / "spacecraft_gnc").rglob("*")
        if path.is_file() and path.suffix in {".typed", ".xml", ".html", ".js", ".css"}
    }
    assert "spacecraft_gnc/py.typed" in data
    assert data <= wheel_files


def test_wheel_holds_the_ros_share_folder(wheel_files: set[str]) -> None:
    shared = {name.partition("/share/")[2] for name in wheel_files if "/share/" in name}
    files = (path for path in (ROOT / "config").rglob("*") if path.is_file())
    configured = {f"spacecraft_gnc/{path.relative_to(ROOT)}" for path in files}
    assert shared == configured | {
        "ament_index/resource_index/packages/spacecraft_gnc",
        "spacecraft_gnc/package.xml",
        "spacecraft_gnc/requirements.lock",
    }


def test_lock_pins_every_dependency_and_names_no_place() -> None:
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    blocks = re.split(r"\n(?=[a-z])", "\n" + lock)[1:]
    assert len(blocks) > 100
    for block in blocks:
        assert re.match(r"[a-z0-9-]+==\S+", block), block
        assert "--hash=sha256:" in block, block
    assert not re.search(r"://|--index|--find-links|--extra-index|@ file", lock)


def test_lock_covers_what_the_package_requires() -> None:
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    locked = set(re.findall(r"^([a-z0-9-]+)==", lock, flags=re.MULTILINE))
    required = metadata.requires("spacecraft_gnc") or []
    names = {re.split(r"[^A-Za-z0-9-]", name)[0].lower() for name in required}
    assert names <= locked
