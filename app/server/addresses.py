"""Under which addresses a server answers a browser on this machine, and one on another."""

import ipaddress
import socket
from typing import Final

_PATIENCE_S: Final = 0.5
_LOOPBACK: Final = ("127.0.0.1", "::1")
_ANY: Final = ("0.0.0.0", "::")
_ANYWHERE: Final = {socket.AF_INET: "192.0.2.1", socket.AF_INET6: "2001:db8::1"}
"""Addresses of nobody, to learn from which address of this machine one would speak to others."""


def answering_addresses(host: str, port: int) -> tuple[str, ...]:
    """Addresses of a server that listens on `host`, without those that do not answer.

    That of this machine alone comes first, if it is among them.
    """
    candidates = (*_LOOPBACK, *_own_addresses()) if host in _ANY else (host,)
    answering = tuple(found for found in candidates if _answers(found, port))
    return tuple(f"http://{_in_url(found)}:{port}" for found in answering or candidates[:1])


def _in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _answers(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), timeout=_PATIENCE_S).close()
    except OSError:
        return False
    return True


def _own_addresses() -> tuple[str, ...]:
    return tuple(
        address
        for family, nobody in _ANYWHERE.items()
        if (address := _address_towards(family, nobody)) is not None
        and not ipaddress.ip_address(address).is_loopback
    )


def _address_towards(family: socket.AddressFamily, other: str) -> str | None:
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            # Nothing is sent by this.
            probe.connect((other, 9))
            return probe.getsockname()[0]
    except OSError:
        return None
