"""`tools/prerequisites.sh`: one line for each thing that the machine lacks."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "prerequisites.sh"
BASE_PYTHON = Path(sys.base_prefix) / "bin" / f"python{sys.version_info[0]}.{sys.version_info[1]}"


@pytest.fixture
def commands(tmp_path: Path) -> Path:
    """Return a folder with all that the script needs, but no Python and no compiler."""
    for name in ("sh", "uname", "getconf"):
        (tmp_path / name).symlink_to(str(shutil.which(name)))
    return tmp_path


def run(commands: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [commands / "sh", SCRIPT, *arguments],
        env={"PATH": str(commands)},
        capture_output=True,
        text=True,
        check=False,
    )


def add_python(commands: Path) -> None:
    # A wrapper, not a link: Python finds its library from the place of its executable.
    wrapper = commands / "python3"
    wrapper.write_text(f'#!{commands}/sh\nexec {BASE_PYTHON} "$@"\n', encoding="utf-8")
    wrapper.chmod(0o755)


def add_compilers(commands: Path) -> None:
    for name in ("cc", "c++"):
        (commands / name).symlink_to(str(commands / "sh"))


def test_complete_machine_prints_its_python(commands: Path) -> None:
    add_python(commands)
    add_compilers(commands)
    result = run(commands)
    assert (result.returncode, result.stdout, result.stderr) == (0, f"{BASE_PYTHON}\n", "")


def test_missing_compiler_is_one_line_with_the_remedy(commands: Path) -> None:
    add_python(commands)
    result = run(commands)
    assert result.returncode == 1
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: no C and C++ compiler")
    assert "apt install build-essential" in line


def test_every_missing_thing_is_told_at_once(commands: Path) -> None:
    result = run(commands)
    assert result.returncode == 1
    first, second = result.stderr.splitlines()
    assert first.startswith("error: Python 3.10 to 3.14 not found")
    assert second.startswith("error: no C and C++ compiler")


def test_an_old_python_named_by_the_user_is_refused_by_name(commands: Path) -> None:
    add_python(commands)
    add_compilers(commands)
    old = commands / "python3.8"
    old.write_text(f"#!{commands}/sh\nexit 1\n", encoding="utf-8")
    old.chmod(0o755)
    result = run(commands, str(old))
    assert result.returncode == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"error: {old} is not Python 3.10 to 3.14")
