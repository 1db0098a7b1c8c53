"""Optional dependencies, and the one-line error when one is missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Final

from spacecraft_gnc.errors import GncError

_OWN_MESSAGES: Final = "spacecraft_gnc_msgs"
_ROS: Final = "the node graph needs ROS 2: pip install 'spacecraft_gnc[ros]'"
_NEEDS: Final = {
    _OWN_MESSAGES: (
        "the node graph needs its messages built: run `make setup` in a checkout, or `colcon build "
        f"--packages-select {_OWN_MESSAGES}` and source install/setup.bash"
    ),
    "rclpy": _ROS,
    "rcl_interfaces": _ROS,
    "builtin_interfaces": _ROS,
    "casadi": "solver: ipopt and the baselines of studies need CasADi: pip install "
    "'spacecraft_gnc[reference]', or choose solver: sqp, or --no-baselines",
    "distributed": "gnc campaign needs dask.distributed: pip install 'spacecraft_gnc[campaign]'",
    "foxglove": "--foxglove needs foxglove-sdk: pip install 'spacecraft_gnc[view]', or leave "
    "--foxglove out for the page that needs nothing",
    "pyarrow": "--format parquet needs pyarrow: pip install 'spacecraft_gnc[export]', or choose "
    "csv, npz or mat",
}
"""Module that an extra brings, and what is to be done without it."""


class MissingDependency(GncError, ModuleNotFoundError):
    """A library that only some commands need is not installed."""


@contextmanager
def explained_imports() -> Iterator[None]:
    """Explain an import error in the context that is caused by a missing extra of the package.

    Raises
    ------
    MissingDependency
        In place of the ModuleNotFoundError of a module that an extra provides.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        need = _need(error.name or "")
        if need is None or isinstance(error, MissingDependency):
            raise
        raise _missing(error.name or "", need) from error


def require_ros() -> None:
    """Refuse a command that starts nodes if ROS 2 is missing; imports nothing.

    Raises
    ------
    MissingDependency
        If rclpy or the messages are not installed.
    """
    for name in ("rclpy", _OWN_MESSAGES):
        with explained_imports():
            if find_spec(name) is None:
                raise _missing(name, _NEEDS[name])


def _need(module: str) -> str | None:
    root = module.partition(".")[0]
    return _NEEDS.get(root, _ROS if root.endswith("_msgs") else None)


def _missing(module: str, need: str) -> MissingDependency:
    root = module.partition(".")[0]
    return MissingDependency(f"{need} (there is no module {root!r})", name=module)
