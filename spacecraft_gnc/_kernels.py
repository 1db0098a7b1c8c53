"""The one way kernels are compiled.

``cache``: compiled once, at set-up. ``error_model="numpy"``: a division by zero gives infinity or
NaN, which the solvers report as a status, instead of an exception in the loop. No fast-math: the
same numbers interpreted (NUMBA_DISABLE_JIT=1) and on every machine with the same libraries.
``no_cfunc_wrapper``: no C callbacks, which nobody calls and which cost a fifteenth of the set-up.
"""

from __future__ import annotations

from numba import njit

kernel = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
