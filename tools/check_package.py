"""Check the package as a user installs it: sdist and wheel, in a clean environment.

Both are built from the files under version control; the wheel built from the sdist must hold the
same files. The wheel is then installed into a clean environment, alone, with ROS, and with every
extra, one after the other as a user follows the remedies, at the versions of the lock; each time
the environment must provide its functions and report a missing one in one line.

usage: python tools/check_package.py
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from email.parser import Parser
from pathlib import Path
from typing import Final, NamedTuple

ROOT: Final = Path(__file__).parents[1]
CONSTRAINTS: Final = "constraints.txt"
FLY: Final = ("simulate", "gupta2015_case1", "--set", "plant.duration=2.0", "--quiet")
NEEDS_ROS: Final = (("gnc", "inspect", "nodes"), ("gnc", "view"))
NEEDS_MESSAGES: Final = (
    ("gnc", "launch", "gupta2015_case1"),
    ("gnc", "slew", "--axis", "0", "0", "1", "--angle-deg", "10"),
    ("plant",),
    ("nmpc_controller",),
    ("reference_governor",),
    ("recorder",),
)


class Failed(Exception):
    """The package fails a check."""


class Result(NamedTuple):
    """Output and exit code of a command."""

    code: int
    out: str
    err: str


def main() -> int:
    """Build, install and test the package; return 1 if a check fails."""
    with tempfile.TemporaryDirectory(prefix="package-") as name:
        folder = Path(name)
        try:
            wheel = build(folder)
            check_metadata(wheel)
            venv = folder / "venv"
            make_environment(venv)
            for extra in ("", "[ros]", "[all]"):
                started = time.monotonic()
                check_installed(venv, f"{wheel}{extra}", extra)
                seconds = time.monotonic() - started
                print(f"spacecraft_gnc{extra}: installed and tried ({seconds:.0f} s)")
        except Failed as error:
            print(f"error: {error}", file=sys.stderr)
            return 1
    return 0


def build(folder: Path) -> Path:
    """Build sdist and wheel; return the wheel."""
    tree, dist = folder / "tree", folder / "dist"
    for name in succeed("git", "-C", ROOT, "ls-files").splitlines():
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, tree / name)
    succeed(sys.executable, "setup.py", "-q", "sdist", "-d", dist, cwd=tree)
    (sdist,) = dist.iterdir()
    for source, out in ((tree, folder / "from_tree"), (sdist, folder / "from_sdist")):
        pip = (sys.executable, "-m", "pip", "wheel", "-qq", "--no-deps", "--no-build-isolation")
        succeed(*pip, "-w", out, source)
    (wheel,), (second,) = (sorted((folder / n).iterdir()) for n in ("from_tree", "from_sdist"))
    if missing := set(names(wheel)) ^ set(names(second)):
        raise Failed(f"{sdist.name}: its wheel differs in {sorted(missing)}")
    return wheel


def check_metadata(wheel: Path) -> None:
    """Check the metadata that an index shows."""
    (file,) = (name for name in names(wheel) if name.endswith(".dist-info/METADATA"))
    with zipfile.ZipFile(wheel) as archive:
        metadata = Parser().parsestr(archive.read(file).decode())
    for field in ("Description-Content-Type", "Project-URL", "Classifier", "License", "Keywords"):
        if metadata[field] is None:
            raise Failed(f"{wheel.name}: its metadata has no {field}")
    if relative := re.findall(r"""(?:\]\(|src=")(?![a-z]+:|#).*""", metadata.get_payload()):
        raise Failed(f"{wheel.name}: relative links in the description: {relative}")


def make_environment(venv: Path) -> None:
    """Make an environment, and a file of the versions of the lock."""
    succeed(sys.executable, "-m", "venv", venv)
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    pins = re.findall(r"^[A-Za-z0-9][^\\\n]*", lock, flags=re.MULTILINE)
    (venv / CONSTRAINTS).write_text("\n".join(pins), encoding="utf-8")


def check_installed(venv: Path, requirement: str, extra: str) -> None:
    """Install into an environment, and test its present and missing functions."""
    pip = (venv / "bin" / "python", "-m", "pip")
    quickly = ("-qq", "--no-compile", "--retries", "10")  # most modules are never imported
    succeed(*pip, "install", *quickly, "-c", venv / CONSTRAINTS, requirement)
    succeed(*pip, "check", "-q")
    gnc, flight = venv / "bin" / "gnc", venv / f"flight{extra}.npz"
    succeed(gnc, "check", "gupta2015_case1")
    # Interpreted, for a flight of five steps: compiling takes a minute, and the set-up tests it.
    succeed(gnc, *FLY, "--out", flight, cwd=venv, NUMBA_DISABLE_JIT="1")
    succeed(gnc, "report", flight, "--out", venv / f"report{extra}.html", NUMBA_DISABLE_JIT="1")
    lacking = "make setup" if extra else "pip install 'spacecraft_gnc[ros]'"
    for command in NEEDS_MESSAGES if extra else (*NEEDS_ROS, *NEEDS_MESSAGES):
        refuse(lacking, venv / "bin" / command[0], *command[1:], cwd=venv)
    if (venv / "runs").exists():
        raise Failed(f"gnc launch of a package without ROS left {venv / 'runs'}")
    for module, named in (("rclpy", "[ros]"), ("pyarrow", "[all]"), ("foxglove", "[all]")):
        expected = 0 if extra in (named, "[all]") else 1
        if run(venv / "bin" / "python", "-c", f"import {module}").code != expected:
            raise Failed(f"spacecraft_gnc{extra}: import {module} should end with {expected}")


def refuse(remedy: str, *command: str | Path, cwd: Path) -> None:
    """Run a command that must fail here with a one-line remedy and exit code 2."""
    result = run(*command, cwd=cwd)
    lines = result.err.splitlines()
    if result.code != 2 or len(lines) != 1 or remedy not in lines[0]:
        raise Failed(
            f"{' '.join(map(str, command))}: ended with {result.code} and {result.err!r}; required "
            f"2 and one line with {remedy!r}"
        )


def succeed(*command: str | Path, cwd: Path | None = None, **variables: str) -> str:
    """Run a command that must succeed; return its output."""
    result = run(*command, cwd=cwd, **variables)
    if result.code != 0:
        shown = " ".join(map(str, command))
        raise Failed(f"{shown}: ended with {result.code}:\n{result.out}{result.err}")
    return result.out


def run(*command: str | Path, cwd: Path | None = None, **variables: str) -> Result:
    """Run a command isolated from the checkout and from other environments."""
    hidden = ("PYTHONPATH", "AMENT_PREFIX_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    done = subprocess.run(
        command, cwd=cwd, env=environment | variables, capture_output=True, text=True, check=False
    )
    return Result(done.returncode, done.stdout, done.stderr)


def names(wheel: Path) -> list[str]:
    """Return the files of a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        return archive.namelist()


if __name__ == "__main__":
    sys.exit(main())
