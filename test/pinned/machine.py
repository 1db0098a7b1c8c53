"""Fingerprint of how a machine computes: equal ones promise the same bits of a flight."""

from __future__ import annotations

import functools
import hashlib
import math
import platform
from collections.abc import Callable, Iterator
from typing import Any

import llvmlite.binding
import numba
import numpy as np
import scipy
import scipy.linalg

_SIZES = (3, 6, 15, 64)  # rows of matrices: of BLAS's small and of its blocked kernels


@functools.cache
def fingerprint() -> dict[str, str]:
    """Return the versions, the processor numba compiles for, and a digest of sample results."""
    digest = hashlib.sha256()
    for result in _results():
        digest.update(np.ascontiguousarray(result).tobytes())
    return {
        "python": ".".join(platform.python_version_tuple()[:2]),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
        "processor": f"{platform.machine()} {numba.config.CPU_NAME or _host()}",
        "results": digest.hexdigest()[:16],
    }


def _host() -> str:
    return str(llvmlite.binding.get_host_cpu_name())


def _results() -> Iterator[Any]:
    x = np.linspace(0.01, 0.99, 1001)
    yield from (f(x) for f in (np.sin, np.cos, np.exp, np.log, np.arctan, np.sqrt, np.cbrt))
    functions: tuple[Callable[[float], float], ...] = (math.sin, math.cos, math.exp, math.atan)
    yield from ([f(value) for value in x] for f in functions)
    for n in _SIZES:
        yield from _algebra(n)
    yield numba.njit(_recursion)(x)


def _algebra(n: int) -> Iterator[Any]:
    """Yield results of BLAS and LAPACK on matrices without symmetries."""
    rows, columns = np.indices((n, n), dtype=float)
    matrix = np.sin(1.7 * rows + 0.3 * columns**2) / n + np.eye(n)
    form = matrix @ matrix.T
    yield from (form, matrix @ matrix[0], np.linalg.inv(matrix), np.linalg.cholesky(form))
    yield from (*np.linalg.eigh(form), *np.linalg.svd(matrix), np.linalg.eigvals(matrix))
    yield np.linalg.lstsq(matrix, form[0], rcond=None)[0]
    yield from (scipy.linalg.expm(0.1 * matrix), scipy.linalg.sqrtm(form))
    yield scipy.linalg.solve_discrete_lyapunov(0.4 * matrix, np.eye(n))


def _recursion(x: Any) -> Any:
    """Return a recursion of products and sums, which a compiler may fuse, and of functions."""
    y = np.empty_like(x)
    state = 0.3
    for i in range(len(x)):
        state = state * x[i] + math.sin(state) * math.cos(x[i]) - math.sqrt(x[i]) / 3.0
        y[i] = state
    return y
