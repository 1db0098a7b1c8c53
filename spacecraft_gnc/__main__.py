"""``python -m spacecraft_gnc`` is ``gnc``."""

from spacecraft_gnc.cli.main import main

if __name__ == "__main__":
    main()
