"""MCAP files of a bag, and whether they are complete.

``metadata.yaml`` says which files belong to the bag. Everything else in it is a copy of what the
files hold, which other producers and editors leave wrong; it is not read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, NamedTuple

import yaml
import zstandard

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording import BAG_FOLDER
from spacecraft_gnc.recording._index import read_index
from spacecraft_gnc.recording.metadata import INFORMATION, METADATA_NAME
from spacecraft_gnc.recording.recover import MAGIC, rewrite

MCAP_SUFFIX: Final = ".mcap"
REQUIRED: Final = "required a bag folder (with metadata.yaml) or a .mcap file"
_PACKED_SUFFIX: Final = f"{MCAP_SUFFIX}.zstd"
_SQLITE_SUFFIX: Final = ".db3"
_NUMBERED: Final = re.compile(r"(.*)_(\d+)\.mcap")
_UNDER_WAY_NS: Final = (
    10**9
)  # what a message of one file may be older than the last of the file before


class BagFiles(NamedTuple):
    """What a bag consists of."""

    files: list[Path]
    """In the order of recording, decompressed."""
    unfinished: bool
    """Whether the recorder was killed, or a file is cut off."""
    strays: tuple[str, ...] = ()
    """Names of .mcap files beside them that ``metadata.yaml`` does not name."""


def bag_in(path: Path) -> Path:
    """Return the bag in the folder of a run; any other path as it is."""
    bag = path / BAG_FOLDER
    is_bag = (path / METADATA_NAME).exists() or bool(_stored(path))
    return bag if bag.is_dir() and not is_bag else path


@contextmanager
def bag_files(path: Path) -> Iterator[BagFiles]:
    """Find the files of a bag; those compressed as a whole are decompressed while it is open.

    Raises
    ------
    RecordingError
        If there is no bag, it is stored in another format, or a file of it is missing, empty or
        not MCAP.
    """
    if path.is_dir():
        with damage(path):
            about = _read_metadata(path)
        stored = _named(path, about) if about is not None else _stored(path)
        strays = tuple(file.name for file in _stored(path) if file not in stored)
    else:
        about, stored, strays = {}, [_single(path)], ()
    if not stored and about is None:
        _refuse_sqlite(path, any(path.glob(f"*{_SQLITE_SUFFIX}")))
        raise RecordingError(f"{path}: received a folder without a bag; {REQUIRED}; check the path")
    with ExitStack() as stack:
        files = [_unpacked(file, stack) for file in stored]
        cut = [file for file in files if not is_whole(file)]
        if about is None:
            files = _one_bag(path, files)
        yield BagFiles(files, bool(cut) or about is None, strays)


def whole_copies(path: Path, files: list[Path], folder: Path) -> list[Path]:
    """Return the files, and in the place of those that were cut off a copy of what is whole.

    Raises
    ------
    RecordingError
        If no message is.
    """
    copies, saved = [], 0
    for i, file in enumerate(files):
        copy = file if is_whole(file) else folder / f"{i}{MCAP_SUFFIX}"
        with damage(path):
            if copy != file:
                rewrite(file, copy)
            saved += sum(read_index(copy).counts.values())
        copies.append(copy)
    if not saved:
        raise RecordingError(
            f"{path}: received an unfinished bag without a whole message; required at least one; "
            "record again"
        )
    return copies


def _stored(folder: Path) -> list[Path]:
    """Return the MCAP files in a folder, those that are compressed too."""
    return sorted([*folder.glob(f"*{MCAP_SUFFIX}"), *folder.glob(f"*{_PACKED_SUFFIX}")])


def _read_metadata(folder: Path) -> dict[str, Any] | None:
    """Return what metadata.yaml says; None where there is none."""
    file = folder / METADATA_NAME
    if not file.exists():
        return None
    try:
        about = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, yaml.YAMLError):
        raise _bad_metadata(folder, "is no YAML") from None
    if not isinstance(about, dict) or not isinstance(about.get(INFORMATION), dict):
        raise _bad_metadata(folder, f"has no {INFORMATION}")
    return dict(about[INFORMATION])


def _named(folder: Path, about: dict[str, Any]) -> list[Path]:
    """Return the files that metadata.yaml names, each once."""
    _refuse_sqlite(folder, about.get("storage_identifier") == "sqlite3")
    names = about.get("relative_file_paths")
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise _bad_metadata(folder, "names no file in relative_file_paths")
    # the oldest versions name them from the folder above
    files = [*dict.fromkeys(folder / Path(name).name for name in names)]
    for file in files:
        if not file.exists():
            there = ", ".join(found.name for found in _stored(folder)) or "no .mcap file"
            raise RecordingError(
                f"{folder}: received {there}; required {file.name}, as its {METADATA_NAME} says; "
                f"give the file back its name, or name a .mcap file instead of the folder"
            )
    return files


def _bad_metadata(folder: Path, problem: str) -> RecordingError:
    there = ", ".join(found.name for found in _stored(folder)) or "no .mcap file beside it"
    return RecordingError(
        f"{folder}: received a {METADATA_NAME} that {problem}; required one that lists the files "
        f"of the bag ({there}); name the .mcap file instead of the folder"
    )


def _single(path: Path) -> Path:
    if not path.exists():
        raise RecordingError(f"{path}: no such file or folder; {REQUIRED}; check the path")
    _refuse_sqlite(path, path.suffix == _SQLITE_SUFFIX)
    if not path.name.endswith((MCAP_SUFFIX, _PACKED_SUFFIX)):
        raise RecordingError(f"{path}: received another kind of file; {REQUIRED}; check the path")
    return path


def _one_bag(folder: Path, files: list[Path]) -> list[Path]:
    """Return the files of a bag that has no metadata.yaml, in order; refuse those of several.

    A recorder that splits its bag numbers the files, and each begins where the last one ended.
    """
    if len(files) == 1:
        return files
    matches = [_NUMBERED.fullmatch(file.name) for file in files]
    numbers = {int(match[2]): file for match, file in zip(matches, files, strict=True) if match}
    one_name = len({match and match[1] for match in matches}) == 1
    ordered = [numbers[number] for number in sorted(numbers)]
    if one_name and sorted(numbers) == [*range(len(files))] and _successive(ordered):
        return ordered
    names = ", ".join(file.name for file in files)
    raise RecordingError(
        f"{folder}: received {len(files)} .mcap files without {METADATA_NAME} that are not one "
        f"bag's parts ({names}); required one bag; name one of the files, or move the others away"
    )


def _successive(files: list[Path]) -> bool:
    """Tell whether each file begins where the last one ended."""
    with damage(files[0].parent):
        spans = [read_index(file).span_ns for file in files if is_whole(file)]
    known = [span for span in spans if span is not None]
    return all(b[0] > a[1] - _UNDER_WAY_NS for a, b in pairwise(known))


def _refuse_sqlite(path: Path, is_sqlite: bool) -> None:
    if is_sqlite:
        folder = path if path.is_dir() else path.parent
        raise RecordingError(
            f"{path}: received a bag with storage sqlite3 (.db3); required MCAP; convert it: "
            f"rosbags-convert --src {folder} --dst {folder}-mcap --dst-storage mcap"
        )


def _unpacked(file: Path, stack: ExitStack) -> Path:
    """Return a file itself or, if it is compressed as a whole, a decompressed copy."""
    if not file.name.endswith(_PACKED_SUFFIX):
        return file
    folder = Path(stack.enter_context(TemporaryDirectory(prefix="gnc_bag_")))
    copy = folder / file.name.removesuffix(".zstd")
    with damage(file), file.open("rb") as source, copy.open("wb") as target:
        zstandard.ZstdDecompressor().copy_stream(source, target)
    if _ends(copy)[0] != MAGIC:
        raise RecordingError(
            f"{file}: received {file.stat().st_size} bytes that decompress to no MCAP file; "
            "required a whole one; copy it again, it may have been cut off"
        )
    return copy


def is_whole(file: Path) -> bool:
    """Tell whether an MCAP file ends as it should.

    Raises
    ------
    RecordingError
        If it is empty, not MCAP, or cannot be read.
    """
    head, tail = _ends(file)
    if not head:
        raise RecordingError(f"{file}: received an empty file; {REQUIRED}; record again")
    if head != MAGIC:
        is_packed = head.startswith(zstandard.FRAME_HEADER)
        kind = "compressed by zstd" if is_packed else "not MCAP"
        remedy = f"rename it to {file.name}.zstd" if is_packed else "check the path"
        raise RecordingError(f"{file}: received a file that is {kind}; {REQUIRED}; {remedy}")
    return tail == MAGIC


def _ends(file: Path) -> tuple[bytes, bytes]:
    """Return the first and the last bytes of a file, as many as the magic has."""
    try:
        with file.open("rb") as stream:
            head = stream.read(len(MAGIC))
            size = stream.seek(0, 2)
            stream.seek(max(size - len(MAGIC), len(head)))
            return head, stream.read()
    except OSError as error:
        raise RecordingError(
            f"{file}: cannot be read ({error.strerror}); {REQUIRED}; check its permissions"
        ) from error


@contextmanager
def damage(path: Path) -> Iterator[None]:
    """Turn whatever a parser raises on damaged or foreign data into a RecordingError."""
    try:
        yield
    except RecordingError:
        raise
    except Exception as error:  # damaged bytes can raise anything in a parser
        reason = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, KeyError):  # its text is the bare key
            reason = f"{reason} is missing"
        raise RecordingError(
            f"{path}: cannot be read as a ROS 2 bag ({reason}); {REQUIRED} that is intact; "
            "record again"
        ) from error
