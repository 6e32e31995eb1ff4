"""The thread that shows runs side by side."""

import threading

import pytest

from app.live.race import Race
from app.page.side.show import Hall, SideShow
from tests.support.races import PATIENCE_S, entry, racing


class OneRace:
    """A session that has a race, at which something is wrong for as long as a test says so."""

    def __init__(self, race: Race | None) -> None:
        self._race = race
        self.fault: str | None = None

    @property
    def race(self) -> Race | None:
        if self.fault is not None:
            raise OSError(self.fault)
        return self._race


class Viewer:
    """Notes what it is shown and told."""

    def __init__(self, fault: str | None = None) -> None:
        self.fault = fault
        self.seen, self.told = threading.Event(), threading.Event()
        self.said: list[str] = []

    def draw(self, hall: Hall | None, now_s: float) -> None:
        if self.fault is not None:
            raise KeyError(self.fault)
        self.seen.set()

    def say(self, text: str) -> None:
        self.said.append(text)
        self.told.set()


def test_what_goes_wrong_is_said_and_the_next_round_shows_them_again(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with racing([entry("timed"), entry("standard_q")]) as race:
        session, viewer = OneRace(race), Viewer()
        session.fault = "no disk"
        show = SideShow(session)  # pyright: ignore[reportArgumentType]
        show.enter(viewer)
        assert viewer.told.wait(PATIENCE_S)
        assert not viewer.seen.is_set()
        session.fault = None
        show.wake()
        assert viewer.seen.wait(PATIENCE_S)
        show.stop()
    assert viewer.said == ["Runs side by side could not be shown: OSError: no disk"]
    assert caplog.messages == ["runs side by side could not be shown"]


def test_others_see_theirs_when_one_cannot_be_drawn() -> None:
    session, one, other = OneRace(None), Viewer("colour"), Viewer()
    show = SideShow(session)  # pyright: ignore[reportArgumentType]
    show.enter(one)
    show.enter(other)
    assert one.told.wait(PATIENCE_S)
    assert other.seen.wait(PATIENCE_S)
    show.stop()
    assert other.said == []
