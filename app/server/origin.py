"""Names and places: what a `Host`, an `Origin` and a `Referer` speak of."""

import ipaddress
import re
import socket
from typing import Final, NamedTuple

from websockets.http11 import Request

_LOOPBACK: Final = frozenset({"127.0.0.1", "localhost", "[::1]"})
_AUTHORITY: Final = re.compile(r"(?P<name>\[[0-9a-f:.]+\]|[^\[\]:/@?#\s]+)(:(?P<port>\d{1,5}))?")
_DEFAULT_HTTP_PORT: Final = 80


class Authority(NamedTuple):
    """The name and port that a `Host` header or an origin speaks of; IPv6 addresses in brackets."""

    name: str
    port: int


def authority_of(text: str) -> Authority | None:
    match = _AUTHORITY.fullmatch(text.lower())
    if match is None:
        return None
    return Authority(match["name"], int(match["port"] or _DEFAULT_HTTP_PORT))


def same_place(one: Authority, other: Authority) -> bool:
    """Whether both speak of one server; the names of the loopback interface count as one."""
    same_name = one.name == other.name or {one.name, other.name} <= _LOOPBACK
    return same_name and one.port == other.port


def source_of(origin: str) -> Authority | None:
    """The place that an origin speaks of; None if it is none that the lab's page can have."""
    scheme, _, rest = origin.partition("://")
    return authority_of(rest) if scheme == "http" else None


def is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def own_names(host: str) -> frozenset[str]:
    bracketed = f"[{host}]" if ":" in host else host
    return _LOOPBACK | {bracketed.lower()}


def machine_names() -> frozenset[str]:
    name = socket.gethostname().lower()
    return frozenset({name, f"{name}.local", socket.getfqdn().lower()})


def is_from_page_of(host: Authority, request: Request) -> bool:
    """Whether a page of `host` made the browser send this request; in doubt, it did not.

    A picture or a link on a foreign page has no `Origin`. Browsers send `Sec-Fetch-Site` to https
    and to the loopback interface alone; in a lab on the network the `Referer` has to tell. A page
    can withhold the latter, and forge neither.
    """
    sites = request.headers.get_all("Sec-Fetch-Site")
    if sites:
        return set(sites) == {"same-origin"}
    referers = request.headers.get_all("Referer")
    if len(referers) != 1:
        return False
    source = source_of("/".join(referers[0].split("/")[:3]))
    return source is not None and same_place(source, host)
