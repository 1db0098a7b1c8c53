"""Console scripts. ``python -m spacecraft_gnc`` is ``gnc``.

Imports are deferred: Ctrl-C ends a command without a traceback even while it is being loaded, and
a node reports a missing ROS 2 in one line.
"""

import sys
from importlib import import_module


def main() -> None:
    """Run ``gnc``."""
    try:
        from spacecraft_gnc.cli.main import main as gnc

        gnc()
    except KeyboardInterrupt:
        sys.exit(130)  # as a shell reports SIGINT


def plant() -> int:
    """Run the plant node."""
    return _run_node("plant")


def nmpc_controller() -> int:
    """Run the controller node."""
    return _run_node("nmpc_controller")


def reference_governor() -> int:
    """Run the governor node."""
    return _run_node("reference_governor")


def recorder() -> int:
    """Run the recorder node."""
    return _run_node("recorder")


def _run_node(name: str) -> int:
    from spacecraft_gnc.extras import MissingDependency, explained_imports

    try:
        with explained_imports():
            return int(import_module(f"spacecraft_gnc.nodes.{name}").main())
    except MissingDependency as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    main()
