"""``python -m spacecraft_gnc`` is ``gnc``."""

import sys


def main() -> None:
    """Run ``gnc``; Ctrl-C ends it without a traceback, even while it is being loaded."""
    try:
        from spacecraft_gnc.cli.main import main as gnc

        gnc()
    except KeyboardInterrupt:
        sys.exit(130)  # as a shell reports SIGINT


if __name__ == "__main__":
    main()
