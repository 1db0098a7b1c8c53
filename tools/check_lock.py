"""Check that newer releases do not affect the set-up.

A local index holds a later release of every locked package beside the locked files. The step of
`make setup` that installs the lock must take exactly the locked ones from there, on every supported
Python found on this machine, with old and new versions of pip.

usage: python tools/check_lock.py [PYTHON]...
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
LOCK: Final = ROOT / "requirements.lock"
INSTALL: Final = ROOT / "tools" / "install_locked.sh"
NEWER: Final = "9999.0"
SUPPORTED: Final = ("3.10", "3.11", "3.12", "3.13", "3.14")
PIPS: Final = {"3.10": "22.0.4", "3.13": "26.3", "3.14": "26.3"}
"""Versions of pip to install with; elsewhere the one that comes with the Python."""
AT_ONCE: Final = 2
REQUIREMENT: Final = re.compile(r"^([A-Za-z0-9._-]+)==(\S+)", flags=re.MULTILINE)


def main() -> int:
    """Check each Python; return 1 if the lock was not installed exactly, or no Python was found."""
    pythons = [Path(name) for name in sys.argv[1:]] or list(found_pythons())
    if not pythons:
        print("error: no Python 3.10 to 3.14 found: install one or name it", file=sys.stderr)
        return 1
    with ThreadPoolExecutor(AT_ONCE) as pool:  # each mostly waits for pip
        return max(pool.map(check, pythons))


def check(python: Path) -> int:
    """Install the lock with ``python`` from an index of later releases; return 1 if it differs."""
    started, version = time.monotonic(), version_of(python)
    with tempfile.TemporaryDirectory(prefix="aged-index-") as folder:
        venv, index = Path(folder, "venv"), Path(folder, "index")
        pip = make_environment(python, venv, version)
        fill_index(index, download(venv, Path(folder, "files")))
        shutil.rmtree(venv)
        make_environment(python, venv, version)
        offline = {**environment(), "PIP_INDEX_URL": index.as_uri(), "PIP_CONFIG_FILE": os.devnull}
        code = subprocess.run([INSTALL, venv, LOCK], env=offline, check=False).returncode
        wrong = differences(venv) if code == 0 else [f"{INSTALL.name} ended with {code}"]
    for line in wrong:
        print(f"error: Python {version}, pip {pip}: {line}", file=sys.stderr)
    if not wrong:
        seconds = time.monotonic() - started
        told = f"Python {version}, pip {pip}: exactly the lock is installed ({seconds:.0f} s)"
        print(told, flush=True)
    return bool(wrong)


def found_pythons() -> Iterator[Path]:
    """Yield an interpreter of each supported version: on PATH, or below pyenv's folder."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
    for version in SUPPORTED:
        candidates = [shutil.which(f"python{version}"), *pyenv.glob(f"{version}.*/bin/python3")]
        for candidate in filter(None, candidates):
            with contextlib.suppress(subprocess.CalledProcessError):
                if version_of(Path(candidate)) == version:
                    yield Path(candidate)
                    break


def version_of(python: Path) -> str:
    """Return "3.11" or the like."""
    told = "import sys; print('%d.%d' % sys.version_info[:2])"
    found = subprocess.run([python, "-c", told], capture_output=True, text=True, check=True)
    return found.stdout.strip()


def environment() -> dict[str, str]:
    """Return the variables of this process without those that select pip's index."""
    places = ("PIP_INDEX_URL", "PIP_EXTRA_INDEX_URL", "PIP_FIND_LINKS", "PIP_NO_INDEX")
    return {name: value for name, value in os.environ.items() if name not in places}


def make_environment(python: Path, venv: Path, version: str) -> str:
    """Make a virtual environment with the pip to check; return that pip's version."""
    subprocess.run([python, "-m", "venv", venv], check=True)
    pip = PIPS.get(version)
    if pip is not None:
        output(venv / "bin" / "python", "-m", "pip", "install", "-qq", f"pip=={pip}")
    return output(venv / "bin" / "python", "-m", "pip", "--version").split()[1]


def download(venv: Path, files: Path) -> Path:
    """Download the locked files for the Python of ``venv`` from pip's configured index."""
    builders = files.parent / "builders.txt"
    blocks = re.split(r"\n(?=[A-Za-z0-9])", LOCK.read_text(encoding="utf-8"))
    builders.write_text("\n".join(b for b in blocks if re.match("(setuptools|wheel)==", b)))
    exactly = ("-qq", "--retries", "10", "--no-deps", "--require-hashes")
    pip = (venv / "bin" / "python", "-m", "pip")
    output(*pip, "install", *exactly, "-r", builders)  # builds the metadata of source-only packages
    output(*pip, "download", *exactly, "--no-build-isolation", "-r", LOCK, "-d", files)
    return files


def fill_index(index: Path, files: Path) -> None:
    """Make a simple index (PEP 503) of the locked files and a later release of each package."""
    index.mkdir()
    for name in {normalized(name) for name, _ in REQUIREMENT.findall(LOCK.read_text("utf-8"))}:
        (index / name).mkdir()
        write_wheel(index / name, name)
    for file in files.iterdir():
        name = re.match(r"(.+?)-\d", file.name)
        if name is not None:
            shutil.move(file, index / normalized(name[1]))
    for folder in index.iterdir():
        links = (
            f'<a href="{path.name}#sha256={hashlib.sha256(path.read_bytes()).hexdigest()}">'
            f"{path.name}</a><br>"
            for path in sorted(folder.iterdir())
        )
        page = "<!DOCTYPE html><html><body>" + "\n".join(links) + "</body></html>"
        (folder / "index.html").write_text(page, encoding="utf-8")


def write_wheel(folder: Path, name: str) -> None:
    """Write an empty wheel of a later release."""
    stem = f"{name.replace('-', '_')}-{NEWER}"
    metadata = f"Metadata-Version: 2.1\nName: {name}\nVersion: {NEWER}\n"
    wheel = "Wheel-Version: 1.0\nGenerator: check\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    with zipfile.ZipFile(folder / f"{stem}-py3-none-any.whl", "w") as archive:
        archive.writestr(f"{stem}.dist-info/METADATA", metadata)
        archive.writestr(f"{stem}.dist-info/WHEEL", wheel)
        archive.writestr(f"{stem}.dist-info/RECORD", "")


def differences(venv: Path) -> list[str]:
    """Return a line for each package that is not installed as locked."""
    installed = {
        normalized(entry["name"]): entry["version"]
        for entry in json.loads(
            output(venv / "bin" / "python", "-m", "pip", "list", "--format", "json")
        )
    }
    wanted = marked(venv)
    known = {normalized(name) for name, _ in REQUIREMENT.findall(LOCK.read_text("utf-8"))}
    given = {"pip", "setuptools"} - wanted.keys()  # installed by `python -m venv`
    # Wheels of ROS contain further distributions, which are not on any index.
    return [
        f"{name}: locked {wanted.get(name)}, installed {installed.get(name)}"
        for name in sorted((known & (wanted.keys() | installed.keys())) - given)
        if wanted.get(name) != installed.get(name)
    ]


def marked(venv: Path) -> Mapping[str, str]:
    """Return the locked version of each package that applies to the Python of ``venv``."""
    program = (
        "import re, sys\n"
        "from pip._vendor.packaging.requirements import Requirement\n"
        "for line in re.findall(r'^[A-Za-z0-9][^\\\\\\n]*', sys.stdin.read(), re.MULTILINE):\n"
        "    r = Requirement(line.strip())\n"
        "    if r.marker is None or r.marker.evaluate():\n"
        "        print(r.name, str(r.specifier)[2:])\n"
    )
    printed = output(venv / "bin" / "python", "-c", program, stdin=LOCK.read_text("utf-8"))
    return {normalized(line.split()[0]): line.split()[1] for line in printed.splitlines()}


def normalized(name: str) -> str:
    """Return a package's name as an index spells it (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()


def output(*command: str | Path, stdin: str | None = None) -> str:
    """Return what a command prints."""
    done = subprocess.run(command, input=stdin, stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
