"""The audience on the *File* tab of one browser: where it looks, how many do, and who presents."""

from typing import Final

import viser
from markupsafe import Markup

from app.page.inbox import Intent
from app.page.presenting import Presenting
from app.page.widgets import CALM, NOTE, add_hints, assign
from app.player.presented import OwnLearners, Stand
from app.util.html import element, joined
from app.words.numbers import counted, shown_number

MOST_REWARDS: Final = 30
"""Of own learners, the best first."""


class Audience:
    """The folder of widgets, in the container that is current."""

    def __init__(self, client: viser.ClientHandle, presenting: Presenting, stand: Stand) -> None:
        self._number, self._presenting, self._stand = client.client_id, presenting, stand
        gui = client.gui
        with gui.add_folder("Audience"):
            self._said = gui.add_html("")
            self._present = gui.add_button(
                "Present from this browser",
                icon=viser.Icon.PRESENTATION,
                color=CALM,
                hint="Show the audience what this browser sees: its layer, its headings, and the"
                " moment that it looks at.",
            )
            self._end = gui.add_button(
                "End the class",
                icon=viser.Icon.ERASER,
                color=CALM,
                visible=stand.classroom is not None,
                hint="Forget seats and answers; whoever goes on takes a new seat.",
            )
        add_hints(gui, self._present, self._end)
        self._present.on_click(Intent(lambda _, __: presenting.take_over(self._number)))
        self._end.on_click(Intent(lambda _, __: self._end_class()))
        self.update()

    def update(self) -> None:
        """Show what is true now."""
        stand, presenter = self._stand, self._presenting.presenter
        is_own = presenter == self._number
        # Another machine cannot reach the address that this one has for itself.
        addresses = stand.addresses[1:] or stand.addresses
        parts: list[Markup | str] = []
        parts += [element("b", address, style="user-select:all") for address in addresses]
        if stand.code is not None:
            parts.append(joined(["Code: ", element("b", stand.code, style="user-select:all")], ""))
        parts.append(f"{counted(stand.n_watchers, 'page')} open.")
        if stand.classroom is not None:
            parts.append(f"{counted(stand.classroom.n_seats, 'seat')} of a class.")
        whose = "this browser" if is_own else "another browser"
        parts.append("Nobody presents." if presenter is None else f"It sees what {whose} sees.")
        if stand.own is not None:
            parts += own_in_words(stand.own)
        content = joined([element("div", part) for part in parts], "")
        assign(self._said, "content", str(element("div", content, style=NOTE)))
        assign(self._present, "disabled", is_own)

    def _end_class(self) -> None:
        if self._stand.classroom is not None:
            self._stand.classroom.end()


def own_in_words(own: OwnLearners) -> list[str]:
    """How the learners of those who look stand, in numbers that say nothing of who they are."""
    said = [f"{counted(own.learners, 'own learner')}, {own.playing} at work."]
    if own.rewards:
        each = [
            f"{shown_number(reward, '.0f')} ({trial:,})"
            for trial, reward in own.rewards[:MOST_REWARDS]
        ]
        if len(own.rewards) > MOST_REWARDS:
            each.append(f"and {len(own.rewards) - MOST_REWARDS} more")
        said.append(f"Reward (at trial): {', '.join(each)}.")
    return said
