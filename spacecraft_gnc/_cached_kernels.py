"""Cache of compiled kernels that loads what a call needs, not what a compilation needs.

Numba's own cache gets the whole compiler ready before it loads a kernel: it imports the
implementations of everything that it can compile (scipy.linalg, numpy.f2py and unittest with them),
compiles its runtime functions, and parses the bitcode that other kernels would link. A node calls a
few kernels and compiles none. The files are Numba's; this class reads them where Numba's would.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any, Final

import llvmlite.binding as llvm
import numba
from numba.core import caching, codegen, config
from numba.core.compiler import CompileResult
from numba.core.runtime import _nrt_python as runtime

IS_TESTED: Final = numba.__version__.startswith("0.68.")
"""Whether numba is of a version whose private parts are those that these modules use."""


class _LoadedLibrary(codegen.JITCodeLibrary):  # type: ignore[misc]  # numba has no types
    """Machine code of a kernel, and its bitcode, which is parsed once another kernel links it."""

    def __init__(self, generator: Any, stored: Any, entry: str) -> None:
        name, _, (code, self._bitcode) = stored
        super().__init__(generator, name)
        self._entry = entry if entry.encode() in code else None
        self.enable_object_caching()
        self._set_compiled_object(code)
        self._finalize_final_module()

    def get_pointer_to_function(self, name: str) -> int:
        """Return the address of a function for calls from Python, or 0 if the code lacks it."""
        if name != self._entry:
            return 0  # LLVM would end the process
        address: int = self._codegen._engine.get_function_address(name)  # noqa: SLF001
        return address

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module: Any = llvm.parse_bitcode(self._bitcode)
        return self._shared_module


class Bitcode(codegen.JITCodeLibrary):  # type: ignore[misc]
    """Bitcode of a kernel that only kernels call, without machine code of its own."""

    codegen = SimpleNamespace(set_env=lambda *_: None)  # no code that has any
    is_inlined = False
    """Whether it is put into its callers, which optimize all that they consist of."""

    @classmethod
    def loaded(cls, generator: Any, stored: Any) -> Bitcode:
        """Return what `serialize_using_object_code` stored."""
        name, _, bitcode = stored
        self = cls(generator, name)
        self._shared_module = llvm.parse_bitcode(bitcode)
        self._finalized = True
        return self

    def get_pointer_to_function(self, name: str) -> int:
        """Return that there is no function that Python can call."""
        return 0

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        """Return what the cache stores."""
        return self.name, "bitcode", self._get_module_for_linking().as_bitcode()

    def _optimize_final_module(self) -> None:
        if not self.is_inlined:
            super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class _Format(caching.CompileResultCacheImpl):  # type: ignore[misc]
    """Numba's format of a cached kernel, whose library parses no bitcode while it is loaded."""

    def rebuild(self, context: Any, payload: Any) -> CompileResult:
        """Return the kernel that numba reduced to a payload (`CompileResult._reduce`)."""
        stored, about, environment, signature, objectmode, lifted, annotation, inits, others = (
            payload
        )
        for initialize in inits:
            initialize()
        if stored[1] == "bitcode":
            library: Any = Bitcode.loaded(context.codegen(), stored)
        else:
            entry = about.llvm_cpython_wrapper_name
            library = _LoadedLibrary(context.codegen(), stored, entry)
        compiled = CompileResult(
            target_context=context,
            typing_context=context.typing_context,
            library=library,
            environment=environment,
            entry_point=context.get_executable(library, about, environment),
            fndesc=about,
            type_annotation=annotation,
            signature=signature,
            objectmode=objectmode,
            lifted=lifted,
            typing_error=None,
            call_helper=None,
            metadata=None,
            reload_init=inits,
            referenced_envs=others,
        )
        for other in others:
            library.codegen.set_env(other.env_name, other)
        return compiled


class KernelCache(caching.FunctionCache):  # type: ignore[misc]
    """Numba's cache of one kernel, with lean loading, and safe beside other processes that compile.

    Compiling gets the compiler ready by itself, also after kernels have been loaded here.
    """

    _impl_class = _Format

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the kernel compiled for a signature, or None if it is not in the cache."""
        if config.NRT_STATS:  # only the whole runtime counts its allocations
            return super().load_overload(signature, context)
        _name_runtime_functions()
        return self._load_overload(signature, context)

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Add a compiled kernel to the cache."""
        self._impl.locator.ensure_cache_path()
        for environment in compiled._find_referenced_environments():  # noqa: SLF001 - as rebuild
            compiled.library.codegen.set_env(environment.env_name, environment)
        with _locked(self.cache_path):
            super().save_overload(signature, compiled)


def keep(kernel: Any) -> None:
    """Have a kernel kept on disk: by `KernelCache`, or in other versions by numba's own cache."""
    if IS_TESTED:
        kernel._cache = KernelCache(kernel.py_func)  # noqa: SLF001 - as enable_caching does
    else:
        kernel.enable_caching()


def _name_runtime_functions() -> None:
    """Tell LLVM where numba's runtime is, as the compiler does (`rtsys.initialize`)."""
    for name, address in runtime.c_helpers.items():
        llvm.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


@contextmanager
def _locked(folder: str) -> Iterator[None]:
    """Hold a folder's lock: two processes that add to one index would lose or mix entries."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
