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
from spacecraft_gnc._kernels import inlined_kernel, kernel


class _ToBitcode(Compiler):  # type: ignore[misc]  # numba has no types
    """Numba's compiler, with `Bitcode` as its product."""

    def define_pipelines(self) -> Any:
        """Return numba's passes."""
        generator, name = self.state.targetctx.codegen(), self.state.func_id.func_qualname
        self.state.library = Bitcode(generator, name)
        self.state.library.is_inlined = bool(self.state.flags.forceinline)
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


def _inner(otherwise: Callable[..., Any], **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles inner kernels with these options, where that is possible."""

    def decorate(function: Callable[..., Any]) -> Any:
        if config.DISABLE_JIT or not IS_TESTED:
            return otherwise(function)
        wanted = {"nopython": True, "boundscheck": None, "error_model": "numpy", **options}
        wanted |= {"no_cfunc_wrapper": True, "no_cpython_wrapper": True}
        compiled = InnerKernel(function, targetoptions=wanted, pipeline_class=_ToBitcode)
        compiled.enable_caching()
        return compiled

    return decorate


inner_kernel = _inner(kernel)
inlined_inner_kernel = _inner(inlined_kernel, forceinline=True)
"""Inner `inlined_kernel`."""
