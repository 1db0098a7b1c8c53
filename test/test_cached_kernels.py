"""Cache of compiled kernels: calls load no compiler, kernels link what was loaded, writers wait."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from numba.core.caching import FunctionCache

from spacecraft_gnc._cached_kernels import KernelCache

ROOT = Path(__file__).resolve().parents[1]
COMPILER = ("numba.np.linalg", "scipy.linalg", "unittest")  # imported with all that numba compiles
CALL = f"""
import sys
from spacecraft_gnc.lie import _mat3_kernels as kernels
identity = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
print(kernels.mat_t_mat(identity, identity) == identity, *(m in sys.modules for m in {COMPILER}))
"""
# Kernels that link one from the cache, which is called before and after.
LINK = """
from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
@inner_kernel
def half(matrix):
    return kernels.mat_scale(0.5, kernels.mat_t_mat(matrix, matrix))
@kernel
def squared(matrix):
    return kernels.mat_add(half(matrix), half(matrix))
@kernel
def halves(matrix):
    return half(half(matrix))
double = tuple(2.0 * entry for entry in identity)
print(squared(double) == tuple(4.0 * entry for entry in identity))
print(kernels.mat_t_mat(identity, identity) == identity, kernels.mat_t_mat.stats.cache_hits.total())
if sys.argv[1:]:
    print(halves(double) == double, half.stats.cache_hits.total())
    half(double)
"""


def run(program: Path, *arguments: object) -> list[str]:
    """Run a program whose compiled kernels are kept beside it; return the lines it prints."""
    cache = program.with_name("cache")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, program, *map(str, arguments)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    return done.stdout.splitlines()


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """Return where a program goes: in a file, since numba caches nothing that is typed in."""
    return tmp_path / "program.py"


def test_a_call_of_a_cached_kernel_loads_no_compiler(program: Path) -> None:
    program.write_text(CALL)
    assert run(program) == ["True True True True"]  # it has been compiled
    assert run(program) == ["True False False False"]


def test_a_kernel_that_was_loaded_can_be_linked_and_called_again(program: Path) -> None:
    program.write_text(CALL)
    run(program)
    program.write_text(CALL + LINK)
    assert run(program) == ["True False False False", "True", "True 1"]
    assert run(program) == ["True False False False", "True", "True 1"]


def test_an_inner_kernel_is_linked_from_the_cache_and_never_called(program: Path) -> None:
    program.write_text(CALL + LINK)
    run(program)
    with pytest.raises(subprocess.CalledProcessError) as failed:
        run(program, "halves")
    assert failed.value.output.splitlines()[-1] == "True 1"
    assert failed.value.stderr.splitlines()[-1] == (
        "TypeError: half: called from Python; only kernels may call it; use half.py_func"
    )


def test_a_kernel_is_added_while_no_other_process_can(monkeypatch: pytest.MonkeyPatch) -> None:
    cache = KernelCache(run)
    cache._impl.locator.ensure_cache_path()
    folder = os.open(cache.cache_path, os.O_RDONLY)  # as another process opens it

    def add(_self: object, *_entry: object) -> None:
        with pytest.raises(BlockingIOError):
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)

    monkeypatch.setattr(FunctionCache, "save_overload", add)
    compiled = SimpleNamespace(_find_referenced_environments=list)
    cache.save_overload("signature", compiled)
    fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    os.close(folder)
