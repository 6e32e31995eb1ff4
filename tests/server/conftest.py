"""Fixtures of the tests of the server."""

import gc
from collections.abc import Iterator

import pytest

from app.server import admission
from tests.support.server import Lab


@pytest.fixture(autouse=True)
def no_grace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(admission, "GRACE_S", 0.0)


@pytest.fixture(autouse=True)
def no_double_clicks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clicks of tests come faster than people's, and each is meant."""
    monkeypatch.setattr(admission, "DOUBLE_S", 0.0)


@pytest.fixture
def no_traceback(
    caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> Iterator[None]:
    """The test must not leave a traceback, neither in a log nor on the terminal."""
    # What is there already need not be looked through, which takes most of a second.
    gc.freeze()
    yield
    gc.collect()  # When asyncio reports a task that failed.
    gc.unfreeze()
    records = [*caplog.get_records("call"), *caplog.records]
    assert [record.getMessage() for record in records if record.exc_info] == []
    assert "Traceback" not in capfd.readouterr().err


@pytest.fixture
def lab() -> Iterator[Lab]:
    lab = Lab()
    yield lab
    lab.close()
