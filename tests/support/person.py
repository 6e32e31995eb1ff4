"""Somebody at the page where there is no browser: finds widgets by their labels, and uses them.

What such a person can do is what `tests.support.screen.Screen` does in a real browser, in the same
words.
"""

import asyncio
import inspect
import re
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from html import unescape
from types import SimpleNamespace
from typing import Any

import viser


def words(html: str) -> str:
    """What a piece of HTML says, without its marks."""
    return " ".join(unescape(re.sub(r"<[^>]*>", "", html)).split())


class Notification:
    """What a page is told; if it stands there, it may be changed."""

    def __init__(self, told: list[str], body: str) -> None:
        self._told = told
        self.title, self.color, self.auto_close_seconds = "", None, 0.0
        self.body = body

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, value)
        if name == "body":
            self._told.append(value)

    def remove(self) -> None:
        pass


class Person:
    """Uses the widgets that the panels of some servers and clients hold, and keeps what it is told.

    A label means the one widget that shows it now; none or several of that label fail the test, and
    so does using one that cannot be used. ``"Folder > Label"`` means the one in that folder.
    """

    client_id = -1
    """Of no browser that is connected."""

    def __init__(self, *guis: viser.GuiApi) -> None:
        self._guis = guis
        self.gui = guis[0]
        """Where panels of their own go."""
        self.told: list[str] = []
        """Notifications, in order."""
        self.downloads: dict[str, bytes] = {}
        """Files that the page gave to keep."""

    # What a page is to those who serve it

    def add_notification(self, title: str, body: str, **_: Any) -> "Notification":
        return Notification(self.told, body)

    def send_file_download(self, filename: str, content: bytes, **_: Any) -> None:
        self.downloads[filename] = content

    # Seeing

    @property
    def html(self) -> str:
        """All pieces of HTML that are shown, one container after the other."""
        return "\n".join(handle.content for handle in self._shown() if hasattr(handle, "content"))

    def reads(self, text: str) -> bool:
        """Whether the page says so, in one piece of text or on a widget."""
        pieces = [handle.content for handle in self._shown() if hasattr(handle, "content")]
        labels = [_label(handle) for handle in self._shown()]
        return any(text in said for said in [*map(words, pieces), *labels])

    def sees(self, label: str) -> bool:
        """Whether something with this label is shown, or a button that says this."""
        return bool(self._found(label))

    def can_use(self, label: str) -> bool:
        """Whether the widget with this label takes a click or a value."""
        # A button group of viser says that it cannot be disabled.
        return not self.widget(label)._impl.props.disabled

    def value(self, label: str) -> Any:
        """What stands in a field, a list, a box or a slider."""
        return self.widget(label).value

    def options(self, label: str) -> list[str]:
        """What a list offers."""
        return list(self.widget(label).options)

    def widget(self, label: str) -> Any:
        """The one widget with this label, or button that says this, as viser has it."""
        found = self._found(label)
        if len(found) != 1:
            known = sorted({_label(handle) for handle in self._shown()} - {""})
            raise AssertionError(f"{len(found)} widgets show {label!r}; there are {known}")
        return found[0]

    # Doing

    def click(self, name: str) -> None:
        """Click on a button."""
        handle = self.widget(name)
        self.send(handle, name if name in _buttons(handle) else True)

    def press(self, command: str) -> None:
        """Press the key of a command."""
        commands = [c for gui in self._guis for c in gui._command_handle_from_uuid.values()]
        (handle,) = (found for found in commands if found.label == command)
        person: Any = self
        for callback in handle._impl.trigger_cb:
            callback(viser.CommandEvent(client=person, client_id=0, target=handle))

    def choose(self, label: str, option: str) -> None:
        """Choose from a list."""
        assert option in self.options(label), f"{label} offers {self.options(label)}"
        self.send(self.widget(label), option)

    def check(self, label: str, checked: bool = True) -> None:
        """Tick a box, or not."""
        self.send(self.widget(label), checked)

    def move(self, label: str, value: float) -> None:
        """Pull a slider to a place."""
        self.send(self.widget(label), value)

    def type(self, label: str, text: object) -> None:
        """Type into a field, key by key, in the place of what stands there, and stay there."""
        typed = str(text)
        self.send(self.widget(label), *(typed[:end] for end in range(1, len(typed) + 1)))

    def fill(self, label: str, text: object) -> None:
        """Type into a field for a number, and leave it."""
        self.type(label, text)
        self.send(self.widget(label), f"{text}\n")

    def upload(self, button: str, name: str, content: str) -> None:
        """Load a file of that name, with a button for it."""
        self.send(self.widget(button), SimpleNamespace(name=name, content=content.encode()))

    def send(self, handle: Any, *values: Any) -> None:
        """What happens when the page sends the values of a widget, one after the other."""
        # In a thread of its own: where a browser was driven before, this one has a loop already.
        with ThreadPoolExecutor(1) as thread:
            thread.submit(asyncio.run, self.sends(handle, *values)).result()

    async def sends(self, handle: Any, *values: Any) -> None:
        """The same in a loop that goes on, for what takes place a while after."""
        person: Any = self
        for value in values:
            assert not handle._impl.props.disabled, f"{_label(handle)} is disabled"
            assert _is_shown(handle), f"{_label(handle)} is not to be seen"
            handle._impl.value = value
            for callback in handle._impl.update_cb:
                done = callback(viser.GuiEvent(client=person, client_id=0, target=handle))
                if inspect.isawaitable(done):
                    await done

    # Finding

    def _shown(self) -> list[Any]:
        """All widgets that are shown, each once, one container after the other."""
        return [handle for gui in self._guis for handle in _all(gui) if _is_shown(handle)]

    def _found(self, label: str) -> list[Any]:
        *folders, name = label.split(" > ")
        return [
            handle
            for handle in self._shown()
            if not isinstance(handle, viser.GuiFolderHandle)
            and name in (_label(handle), *_buttons(handle))
            and set(folders) <= {_label(above) for above in _above(handle)}
        ]


class AtOnce:
    """Stands for the inbox: what is asked for is done at once."""

    def put(self, act: Callable[[], object]) -> None:
        act()

    def work(self, _: object, make: Callable[[], Any], then: Callable[[Any], object]) -> None:
        then(make())


def _all(gui: viser.GuiApi) -> Iterator[Any]:
    """All widgets of a server or a client."""
    found: dict[str, Any] = {}
    for container in [*gui._container_handle_from_uuid.values()]:
        found |= container._children
    # What a client has put into a container of the server.
    return iter((found | gui._handles_in_foreign_containers).values())


def _label(handle: Any) -> str:
    """What is written on a widget, or beside it."""
    return getattr(handle, "label", None) or ""


def _buttons(handle: Any) -> tuple[str, ...]:
    """What is written on the buttons of a group."""
    return handle.options if isinstance(handle, viser.GuiButtonGroupHandle) else ()


def _above(handle: Any) -> Iterator[Any]:
    """A widget, and all that it lies in."""
    while hasattr(handle, "_impl"):
        yield handle
        gui, above = handle._impl.gui_api, handle._impl.parent_container_id
        handle = gui._resolve_container_handle(above)


def _is_shown(handle: Any) -> bool:
    """Whether a widget and all that it lies in are visible."""
    return all(getattr(above, "visible", True) for above in _above(handle))


def drawn(scene: viser.SceneApi, name: str) -> Any:
    """What is drawn under a name in the scene of a server or of a client, as viser has it."""
    return scene._handle_from_node_name[name]
