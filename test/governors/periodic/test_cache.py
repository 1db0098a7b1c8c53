"""The cache of the sets: what comes back, what is refused, where it lies."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from periodic_loops import random_loop

from spacecraft_gnc.governors.periodic import SetOptions, cached_sets
from spacecraft_gnc.governors.periodic.cache import FOLDER_VARIABLE, cache_folder, data_key

LOOP, CONSTRAINTS = random_loop(3, 2)
COLUMNS = ("state_rows", "reference_rows", "bounds", "constraint", "ahead")


def same(one, other):
    assert one.names == other.names
    assert np.array_equal(one.inside, other.inside)
    assert (one.determined, one.steps, one.excess) == (other.determined, other.steps, other.excess)
    for a, b in zip(one.sets, other.sets, strict=True):
        for name in COLUMNS:
            assert np.array_equal(getattr(a, name), getattr(b, name))


def fetch(folder, options=None):
    """Return sets, the number of backward steps taken for them, and the notices."""
    steps, notices = [], []
    sets = cached_sets(
        LOOP,
        CONSTRAINTS,
        options,
        lambda *call: steps.append(call),
        folder=folder,
        notice=notices.append,
    )
    return sets, len(steps), notices


def test_the_second_time_the_same_sets_are_read(tmp_path):
    first, steps, _ = fetch(tmp_path / "new" / "folder")
    assert steps == first.steps
    second, steps, notices = fetch(tmp_path / "new" / "folder")
    assert (steps, notices) == (0, [])
    same(first, second)
    assert len(list((tmp_path / "new" / "folder").glob("*.npz"))) == 1
    with pytest.raises(ValueError, match="read-only"):
        second.at(0).bounds[0] = 0.0


def test_other_data_are_other_sets(tmp_path):
    fetch(tmp_path)
    _, steps, _ = fetch(tmp_path, SetOptions(steady_share=0.98))
    assert steps > 0
    keys = {data_key(*random_loop(seed, 2), SetOptions()) for seed in range(5)}
    keys |= {data_key(LOOP, CONSTRAINTS, SetOptions(tolerance=1e-8))}
    assert len(keys) == 6  # one of the five is LOOP's
    assert data_key(*random_loop(3, 2), SetOptions()) in keys


def cut(path, other):
    path.write_bytes(path.read_bytes()[:-100])


def turned(path, other):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))


def exchanged(path, other):
    path.write_bytes(other.read_bytes())


def text(path, other):
    path.write_text("no sets\n")


def plain(path, other):
    with path.open("wb") as file:
        np.save(file, np.ones(3))


def foreign(path, other):
    np.savez(path, bounds=np.ones(3))


def pickled(path, other):
    np.savez(path, bounds=np.array([{}], dtype=object))


def altered(path, other):
    with np.load(path) as file:
        arrays = dict(file)
    arrays["bounds"] = 2.0 * arrays["bounds"]
    np.savez(path, **arrays)


@pytest.mark.parametrize("harm", [cut, turned, exchanged, text, plain, foreign, pickled, altered])
def test_a_file_that_is_not_what_it_should_be_is_replaced(tmp_path, harm):
    whole, _, _ = fetch(tmp_path)
    (path,) = tmp_path.glob("*.npz")
    fetch(tmp_path, SetOptions(steady_share=0.98))
    (other,) = (file for file in tmp_path.glob("*.npz") if file != path)
    harm(path, other)
    again, steps, notices = fetch(tmp_path)
    assert steps == whole.steps
    assert len(notices) == 1
    assert "computed again" in notices[0]
    same(whole, again)
    assert fetch(tmp_path)[1:] == (0, [])


def test_without_a_folder_to_write_to_the_sets_are_still_there(tmp_path):
    (tmp_path / "file").write_text("in the way")
    whole, steps, notices = fetch(tmp_path / "file" / "folder")
    assert steps == whole.steps
    assert "cannot be written" in notices[0]
    whole, _, _ = fetch(tmp_path / "file" / "folder")
    assert whole.determined


def test_a_file_half_written_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "savez_compressed", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fetch(tmp_path)
    assert [file.suffix for file in tmp_path.iterdir()] == [".lock"]


@pytest.mark.parametrize(
    ("platform", "folder"),
    [("linux", "/caches"), ("darwin", "~/Library/Caches"), ("win32", "/local")],
)
def test_the_folder_is_the_users_of_the_platform(monkeypatch, platform, folder):
    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.delenv(FOLDER_VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/caches")
    monkeypatch.setenv("LOCALAPPDATA", "/local")
    assert cache_folder() == Path(folder).expanduser() / "spacecraft_gnc" / "periodic_sets"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")  # to be ignored, the standard says
    if platform == "linux":
        assert cache_folder().is_relative_to(Path("~/.cache").expanduser())


def test_the_environment_names_another_folder(monkeypatch, tmp_path):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    assert cache_folder() == tmp_path
    assert fetch(None)[1] > 0
    assert fetch(None)[1] == 0


def test_of_several_that_ask_at_once_one_computes(tmp_path):
    with ThreadPoolExecutor(3) as pool:  # each opens the lock for itself, as a process would
        told = list(pool.map(lambda _: fetch(tmp_path)[1:], range(3)))
    assert sorted(steps > 0 for steps, _ in told) == [False, False, True]
    assert all("waiting for it" in notice for _, notices in told for notice in notices)
