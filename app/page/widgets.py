"""Widgets show the state and never are the state: the ways in which they meet it."""

import time
from collections.abc import Callable, Mapping
from typing import Any, Final, Generic, TypeVar

import viser

from app.page.inbox import Act, Intent
from app.util.html import element, joined

Id = TypeVar("Id")

TOUCHED_S = 0.5
"""A widget that was touched so lately is left alone: a slider may still be in somebody's hand."""

CALM: Final = "gray"
"""Colour of a button that is not the one to begin with; the stylesheet gives it but an outline."""
NOTE: Final = "padding:0 0.7em 0.5em;font-size:0.85em;overflow-wrap:anywhere"
"""Style of what is said below widgets."""
DESTROYS: Final = "red"
"""Colour of a button that puts an end to something."""

NAME_HTML: Final = '<div class="pounce-name"></div>'
"""Stands before a field for a name, whose text the page's script is to leave as it is typed."""


def assign(handle: Any, name: str, value: object) -> None:
    """Set a property only if it differs, so that nothing is sent for nothing."""
    if getattr(handle, name) != value:
        # viser sends plain texts alone, and no markup.
        setattr(handle, name, str(value) if isinstance(value, str) else value)


def add_hints(gui: viser.GuiApi, *buttons: Any) -> None:
    """Have buttons tell their hints, which viser does for other widgets alone.

    A script of the page finds a button by the id that both have (``app/web/hints.js``).
    """
    hints = joined(
        element("span", button.hint, hidden="", **{"data-hint-of": button._impl.uuid})
        for button in buttons
    )
    gui.add_html(str(hints))


class Input:
    """A widget that people set and the program, too; neither loses what the other has set.

    As long as it holds what the program last knew of, it shows what is true. If it holds something
    else, a person has just set that, and the inbox is about to tell.
    """

    def __init__(self, handle: Any, changed: Act) -> None:
        """``changed`` is called with what a person has set."""
        self.handle = handle
        self._known = handle.value
        self._changed = changed
        self._touched_s = 0.0
        handle.on_update(Intent(self._take))

    def show(self, value: object) -> None:
        """Show what is true, unless somebody has just set it."""
        if self.rests(TOUCHED_S):
            self.put(value)

    def put(self, value: object) -> None:
        """Set it now, unless somebody has set it to what nobody knows of yet."""
        if self.handle.value == self._known:
            assign(self.handle, "value", value)
            self._known = self.handle.value

    def rests(self, for_s: float) -> bool:
        """Whether nobody has touched it for so long."""
        known = self.handle.value == self._known
        return known and time.monotonic() - self._touched_s > for_s

    def renew(self) -> None:
        """Take what it holds for known."""
        self._known = self.handle.value

    def _take(self, client: viser.ClientHandle, value: Any) -> None:
        self.renew()
        self._touched_s = time.monotonic()
        self._changed(client, value)


class Choice(Generic[Id]):
    """A list to choose from: labels are shown, and the id of one of them is chosen."""

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        options: Mapping[str, Id],
        changed: Callable[[viser.ClientHandle, Id], object] = lambda _, __: None,
        nothing: str = "",
        hint: str | None = None,
    ) -> None:
        """Offer the ids of ``options`` by their labels; without any, None, which is ``nothing``.

        ``changed`` is called with what a person has chosen.
        """
        self._nothing: dict[str, Any] = {nothing: None}
        self._ids: dict[str, Id] = dict(options) or self._nothing
        self.handle: Any = gui.add_dropdown(label, tuple(self._ids), hint=hint)
        self._changed = changed
        self._input = Input(self.handle, self._take)

    @property
    def chosen(self) -> Id:
        """The id that is chosen."""
        return self._ids[self.handle.value]

    def offer(self, options: Mapping[str, Id]) -> bool:
        """Offer these; what is chosen stays so if it is among them, or else is the first.

        Returns:
            Whether they are others than before.
        """
        ids = dict(options) or self._nothing
        if list(ids.items()) == list(self._ids.items()):
            return False
        chosen = self.chosen
        # In between, a page may still choose by one of the labels before.
        self._ids = {**self._ids, **ids}
        assign(self.handle, "options", tuple(ids))
        self._ids = ids
        self._input.renew()
        # What is called as before may be something else.
        self.choose(chosen if chosen in ids.values() else next(iter(ids.values())))
        return True

    def choose(self, wanted: Id) -> None:
        """Choose something that is offered, unless somebody has just chosen something else."""
        self._input.put(next(label for label, id_ in self._ids.items() if id_ == wanted))

    def _take(self, client: viser.ClientHandle, label: str) -> None:
        # It may not be offered any more.
        if label in self._ids:
            self._changed(client, self._ids[label])


def add_buttons(
    gui: viser.GuiApi,
    label: str,
    options: Mapping[str, Id],
    pressed: Callable[[viser.ClientHandle, Id], object],
    **looks: Any,
) -> viser.GuiButtonGroupHandle:
    """A row of buttons; ``pressed`` is called with the id of one. ``looks`` are viser's."""
    group = gui.add_button_group(label, tuple(options), **looks)
    group.on_click(Intent(lambda client, name: pressed(client, options[name])))
    return group
