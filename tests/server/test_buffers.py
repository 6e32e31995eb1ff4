"""viser's outgoing buffers, filled by many threads while pages wait for what comes."""

import threading
import warnings

import viser

from app.server.server import close_server, open_server
from tests.support.server import CAMERA, Page

PUSHES = 3_000
PATIENCE_S = 60.0


def test_any_thread_may_write_while_pages_wait_for_what_comes() -> None:
    server = open_server(port=0)
    failures: list[BaseException] = []
    shown = server.gui.add_html("")

    def write(name: str) -> None:
        try:
            for number in range(PUSHES):
                shown.content = f"{name} {number}"
        except RuntimeError as error:
            failures.append(error)

    pages = [Page(server.get_port()) for _ in range(3)]
    writers = [threading.Thread(target=write, args=(name,)) for name in "ab"]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert failures == []
    for page in pages:
        page.close()
    close_server(server)


def test_what_is_meant_for_a_page_that_has_left_is_lost_without_a_word() -> None:
    server = open_server(port=0)
    here, gone = threading.Event(), threading.Event()
    seen: list[viser.GuiHtmlHandle] = []

    def welcome(client: viser.ClientHandle) -> None:
        seen.append(client.gui.add_html(""))
        here.set()

    server.on_client_connect(welcome)
    server.on_client_disconnect(lambda client: gone.set())
    page = Page(server.get_port())
    page.send(CAMERA)
    assert here.wait(PATIENCE_S)
    page.close()
    assert gone.wait(PATIENCE_S)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        seen[0].content = "for nobody"
    close_server(server)
