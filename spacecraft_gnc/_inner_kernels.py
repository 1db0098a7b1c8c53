"""Kernels that only kernels call: compiled to bitcode, which their callers link and optimize again.

A kernel that Python may call costs machine code and a function that converts Python's arguments, a
quarter of the time of its compilation, which an inner kernel has no use for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.core import config
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

from spacecraft_gnc._cached_kernels import IS_TESTED, Bitcode, KernelCache
from spacecraft_gnc._kernels import kernel


class _ToBitcode(Compiler):  # type: ignore[misc]  # numba has no types
    """Numba's compiler, with `Bitcode` as its product."""

    def define_pipelines(self) -> Any:
        """Return numba's passes."""
        generator, name = self.state.targetctx.codegen(), self.state.func_id.func_qualname
        self.state.library = Bitcode(generator, name)
        return super().define_pipelines()


class InnerKernel(CPUDispatcher):  # type: ignore[misc]
    """Kernel that only kernels can call."""

    def add_overload(self, compiled: Any) -> None:
        """Add a signature for callers that link it."""
        self.overloads[tuple(compiled.signature.args)] = compiled

    def enable_caching(self) -> None:
        """Keep what is compiled."""
        self._cache = KernelCache(self.py_func)

    def _compile_for_args(self, *_args: Any, **_keywords: Any) -> None:
        name = self.py_func.__name__
        message = f"{name}: called from Python; only kernels may call it; use {name}.py_func"
        raise TypeError(message)


def inner_kernel(function: Callable[..., Any]) -> Any:
    """Compile a kernel that only kernels call."""
    if config.DISABLE_JIT or not IS_TESTED:
        return kernel(function)
    options = {"nopython": True, "boundscheck": None, "error_model": "numpy"}
    options |= {"no_cfunc_wrapper": True, "no_cpython_wrapper": True}
    compiled = InnerKernel(function, targetoptions=options, pipeline_class=_ToBitcode)
    compiled.enable_caching()
    return compiled
