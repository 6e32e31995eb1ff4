"""Asking before something that others would miss is done."""

from collections.abc import Callable

import viser

from app.page.inbox import Intent
from app.page.widgets import CALM, DESTROYS
from app.server.notices import close_modal, open_modal
from app.util.html import element


def confirm(
    client: viser.ClientHandle,
    title: str,
    text: str,
    answers: tuple[str, str],
    act: Callable[[], object],
) -> None:
    """Ask one page whether something is to be done.

    Args:
        client: the page.
        title: the question.
        text: what comes of it, as plain text.
        answers: yes and no, as the buttons say it.
        act: what is done at yes.
    """
    modal = open_modal(client, title)
    with modal:
        client.gui.add_html(str(element("p", text, style="margin:0 0 0.7em;padding:0 0.7em")))
        yes = client.gui.add_button(answers[0], color=DESTROYS)
        no = client.gui.add_button(answers[1], color=CALM)

    def agreed(*_: object) -> None:
        close_modal(modal)
        act()

    yes.on_click(Intent(agreed))
    no.on_click(Intent(lambda _, __: close_modal(modal)))


def confirm_for_all(
    client: viser.ClientHandle, n_others: int, deed: str, at: str, act: Callable[[], object]
) -> None:
    """Ask one page whether what other browsers look at is to be taken away from them, too.

    Args:
        client: the page.
        n_others: how many others look, at least 1.
        deed: what is to be done, as a button says it.
        at: what they look at, and what becomes of it, as a sentence without its beginning.
        act: what is done at yes.
    """
    others = "1 other browser looks" if n_others == 1 else f"{n_others} others look"
    confirm(client, f"{deed} for all?", f"{others} at {at}", (f"{deed} for all", "No"), act)
