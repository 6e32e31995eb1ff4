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
