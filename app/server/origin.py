"""Names and places: what a `Host`, an `Origin` and a `Referer` speak of, and which are our own."""

import ipaddress
import re
import socket
from collections.abc import Iterable, Mapping
from typing import Final, NamedTuple
from urllib.parse import urlsplit

import idna
from websockets.http11 import Request

_LOOPBACK: Final = frozenset({"127.0.0.1", "localhost", "[::1]"})
_AUTHORITY: Final = re.compile(r"(?P<name>\[[0-9a-f:.]+\]|[^\[\]:/@?#\s]+)(:(?P<port>\d{1,5}))?")
_LABEL: Final = re.compile(r"(?!-)[a-z0-9_-]{1,63}(?<!-)")
_MAX_NAME_CHARACTERS: Final = 253
_MAX_PORT: Final = 65_535
_DEFAULT_PORTS: Final = {"http": 80, "https": 443}


class Authority(NamedTuple):
    """What a `Host` speaks of; IPv6 addresses in brackets, no port where the default is meant."""

    name: str
    port: int | None

    def __str__(self) -> str:
        return self.name if self.port is None else f"{self.name}:{self.port}"


class Source(NamedTuple):
    """The place that a page comes from."""

    name: str
    port: int
    default_port: int
    """What a `Host` means that has no port, if the page was fetched as this one was."""

    @property
    def place(self) -> Authority:
        return Authority(self.name, None if self.port == self.default_port else self.port)


def authority_of(text: str) -> Authority | None:
    match = _AUTHORITY.fullmatch(text.lower())
    if match is None:
        return None
    # A name that ends in a dot is the same name, said to be whole.
    name = match["name"].removesuffix(".")
    port = None if match["port"] is None else int(match["port"])
    if not name or (port or 0) > _MAX_PORT:
        return None
    return Authority(name, port)


def source_of(origin: str) -> Source | None:
    """The place that an origin speaks of; None if it is none that the lab's page can have."""
    scheme, _, rest = origin.partition("://")
    authority = authority_of(rest)
    default_port = _DEFAULT_PORTS.get(scheme)
    if authority is None or default_port is None:
        return None
    return Source(authority.name, authority.port or default_port, default_port)


def is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def is_loopback(host: str) -> bool:
    """Whether who listens there is heard by its own machine alone."""
    if not is_address(host):
        return host.lower() == "localhost"
    return ipaddress.ip_address(host).is_loopback


def declared_name(text: str) -> Authority:
    """A name that the lab is to answer to, as its owner writes it, with or without a port.

    Raises:
        ValueError: no host can have that name.
    """
    authority = authority_of(text.strip())
    if authority is None:
        raise ValueError("no name of a host")
    if authority.name.startswith("["):
        if not is_address(authority.name):
            raise ValueError("no address")
        return authority
    name = authority.name
    if not name.isascii():
        # Browsers send what the name is written as in the DNS.
        try:
            name = idna.encode(name, uts46=True).decode("ascii")
        except idna.IDNAError as error:
            raise ValueError(str(error)) from error
    labels = name.split(".")
    if len(name) > _MAX_NAME_CHARACTERS or not all(map(_LABEL.fullmatch, labels)):
        raise ValueError("no name of a host")
    if labels[-1].isdigit() and not is_address(name):
        raise ValueError("no address")
    return Authority(name, authority.port)


def names_of_workspace(environment: Mapping[str, str], port: int) -> tuple[Authority, ...]:
    """Under which names a cloud workspace says that it forwards a port of this machine."""
    places = []
    codespace = environment.get("CODESPACE_NAME")
    domain = environment.get("GITHUB_CODESPACES_PORT_FORWARDING_DOMAIN")
    if codespace and domain:
        places.append(f"{codespace}-{port}.{domain}")
    template = environment.get("VSCODE_PROXY_URI")
    if template:
        places.append(urlsplit(template.replace("{{port}}", str(port))).netloc)
    return tuple(found for place in places if (found := authority_of(place)) is not None)


class Names:
    """Which names are this server's, and which pages come from it."""

    def __init__(self, host: str, declared: Iterable[Authority]) -> None:
        """`host` is the address that the server listens on."""
        self._any_address = is_address(host) and ipaddress.ip_address(host).is_unspecified
        self._declared = tuple(declared)
        bracketed = f"[{host}]" if ":" in host else host
        self._names = (
            _LOOPBACK
            | {bracketed.lower()}
            | {authority.name for authority in self._declared}
            | (_machine_names() if self._any_address else frozenset())
        )

    def have(self, host: Authority) -> bool:
        """Whether a request to this host means us.

        Ports do not count: behind a forwarded port the browser knows another one.
        """
        return host.name in self._names or (self._any_address and is_address(host.name))

    def are_of(self, source: Source | None, host: Authority) -> bool:
        """Whether a page of `source` is ours, where a request of its is addressed to `host`.

        It is where both name one place. A proxy may put a name of its own in place of the `Host`
        that the browser sent; then it is where the owner declared the place, by its port as well,
        since at another port of that host somebody else may live. Headers by which a proxy tells
        what it replaced prove nothing: nobody knows who wrote them.
        """
        if source is None:
            return False
        return _same_place(source, host) or any(
            _same_place(source, declared) for declared in self._declared
        )


def _same_place(source: Source, host: Authority) -> bool:
    """Whether both speak of one server; the names of the loopback interface count as one."""
    same_name = source.name == host.name or {source.name, host.name} <= _LOOPBACK
    return same_name and source.port == (host.port or source.default_port)


def _machine_names() -> frozenset[str]:
    name = socket.gethostname().lower()
    return frozenset({name, f"{name}.local", socket.getfqdn().lower()})


def is_from_own_page(names: Names, host: Authority, request: Request) -> bool:
    """Whether a page of ours made the browser send this request; in doubt, it did not.

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
    return names.are_of(source_of("/".join(referers[0].split("/")[:3])), host)
