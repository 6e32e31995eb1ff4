"""What a page is told and asked, one thing at a time."""

from collections.abc import Iterator
from typing import Any

import pytest

from app.server import notices
from app.server.callbacks import RefusedError, guarded
from app.server.notices import open_modal, tell
from tests.support.server import Lab, Page, lab_of


@pytest.fixture(scope="module")
def lab() -> Iterator[Lab]:
    with lab_of() as lab:
        yield lab


class Screen:
    """The notifications and modals that stand on a page, by what it was sent."""

    def __init__(self) -> None:
        self.notifications: dict[str, Any] = {}
        self.modals: dict[str, str] = {}

    def take(self, message: dict[str, Any]) -> None:
        match message["type"]:
            case "NotificationShowMessage":
                self.notifications[message["uuid"]] = message["props"]
            case "NotificationUpdateMessage":
                # A page ignores one for a notification that is not there.
                if message["uuid"] in self.notifications:
                    self.notifications[message["uuid"]] = message["props"]
            case "RemoveNotificationMessage":
                self.notifications.pop(message["uuid"], None)
            case "GuiModalMessage":
                self.modals[message["uuid"]] = message["title"]
            case "GuiCloseModalMessage":
                self.modals.pop(message["uuid"], None)

    def bodies(self) -> list[str]:
        return [props["body"] for props in self.notifications.values()]


def received(page: Page) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []

    def keep(message: dict[str, Any]) -> bool:
        found.append(message)
        return message["type"] == "NotificationShowMessage" and message["props"]["title"] == "End"

    page.receive_until(keep)
    return found[:-1]


def shown(page: Page, client: Any) -> Screen:
    """What stands on a page once it has taken all that it was sent."""
    client.add_notification("End", "")
    screen = Screen()
    for message in received(page):
        screen.take(message)
    return screen


def test_newest_takes_the_place_of_the_last(lab: Lab) -> None:
    page, client = lab.page()
    for number in range(1_000):
        tell(client, "Not accepted", f"reason {number}")
    assert shown(page, client).bodies() == ["reason 999"]


def test_what_comes_later_is_shown_anew(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notices, "UPDATE_S", 0.0)
    page, client = lab.page()
    tell(client, "Not accepted", "one")
    first = shown(page, client)
    assert first.bodies() == ["one"]
    tell(client, "Loaded", "two")
    second = shown(page, client)
    assert second.bodies() == ["two"]
    assert first.notifications.keys() != second.notifications.keys()


def test_pages_are_told_apart(lab: Lab) -> None:
    (one, first), (other, second) = lab.page(), lab.page()
    tell(first, "Not accepted", "one")
    tell(second, "Not accepted", "two")
    assert shown(one, first).bodies() == ["one"]
    assert shown(other, second).bodies() == ["two"]


def test_refusals_of_callbacks_are_told_one_at_a_time(lab: Lab) -> None:
    page, client = lab.page()

    def refuse(number: int) -> None:
        raise RefusedError(f"reason {number}")

    for number in range(100):
        guarded(lambda _, number=number: refuse(number))(client)
    assert shown(page, client).bodies() == ["reason 99"]


def test_one_modal_at_a_time(lab: Lab) -> None:
    page, client = lab.page()
    for number in range(20):
        modal = open_modal(client, f"Question {number}")
        with modal:
            client.gui.add_button("Yes")
    screen = shown(page, client)
    assert list(screen.modals.values()) == ["Question 19"]
    assert len(client.gui._modal_handle_from_uuid) == 1
    assert len(client.gui._gui_input_handle_from_uuid) == 1
