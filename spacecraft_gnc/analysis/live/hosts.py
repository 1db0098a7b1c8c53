"""Names of this machine, as URLs and requests have them."""

from __future__ import annotations

import ipaddress
import socket
from typing import Final
from urllib.parse import urlsplit

_LOCAL_NAMES: Final = ("localhost", "127.0.0.1", "::1")


def url_host(host: str) -> str:
    """Return a host as a URL on this machine has it."""
    if host in ("0.0.0.0", "::"):  # noqa: S104 - compared, not bound
        return "127.0.0.1" if host == "0.0.0.0" else "[::1]"  # noqa: S104
    return f"[{host}]" if ":" in host else host


def is_loopback(host: str) -> bool:
    """Tell whether only this machine can reach a server bound to ``host``."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def host_is_ours(header: str | None, bound_host: str) -> bool:
    """Tell whether a Host header names this machine.

    Bound to loopback, only its names do. Otherwise an address or the machine's own name does too:
    an address cannot be made to point elsewhere.
    """
    try:
        name = urlsplit(f"//{header}").hostname if header else None
    except ValueError:
        return False
    if not name:
        return False
    if name in (*_LOCAL_NAMES, bound_host.lower()):
        return True
    if is_loopback(bound_host):
        return False
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return name == socket.gethostname().lower()
    return True
