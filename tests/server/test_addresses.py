"""The addresses that are printed are those that answer."""

import http.client
import socket
from urllib.parse import urlsplit

import pytest

from app.server.server import addresses_of
from tests.support.server import PATIENCE_S, lab_of


def has_ipv6() -> bool:
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError:
        return False
    return True


needs_ipv6 = pytest.mark.skipif(not has_ipv6(), reason="this machine has no IPv6")


def status_of(address: str) -> int:
    parts = urlsplit(address)
    assert parts.hostname is not None
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=PATIENCE_S)
    connection.request("GET", "/")
    return connection.getresponse().status


@pytest.mark.parametrize(
    ("host", "first"),
    [
        ("127.0.0.1", "http://127.0.0.1:{port}"),
        ("localhost", "http://127.0.0.1:{port}"),
        ("0.0.0.0", "http://127.0.0.1:{port}"),
        pytest.param("::1", "http://[::1]:{port}", marks=needs_ipv6),
        pytest.param("::", None, marks=needs_ipv6),
    ],
)
def test_all_addresses_answer(host: str, first: str | None) -> None:
    with lab_of(host=host) as lab:
        addresses = addresses_of(lab.server)
        assert addresses
        assert [status_of(address) for address in addresses] == [200] * len(addresses)
        if first is not None:
            assert addresses[0] == first.format(port=lab.port)


def test_on_one_address_there_is_no_other() -> None:
    with lab_of(host="127.0.0.1") as lab:
        assert addresses_of(lab.server) == (f"http://127.0.0.1:{lab.port}",)
