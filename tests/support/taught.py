"""The page of a lesson's card without a lab: it is told states, and what it says is kept."""

from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from playwright.sync_api import ConsoleMessage, Page, Route

from app.server import web_files

ORIGIN: Final = "http://lesson.test"
_WEB: Final = Path(web_files.__file__).resolve().parent.parent / "web"
_KINDS: Final = {".js": "text/javascript", ".css": "text/css"}
_FRAME: Final = '<script type="module" src="../../web/lesson/frame.js"></script>'
_SINK: Final = """<script type="module">
    import { connectTo, hear } from "../../web/player/pipe.js";
    import "../../web/lesson/page.js";
    window.sent = [];
    connectTo({ send: message => { window.sent.push(message); return true; } });
    window.hear = hear;
    document.documentElement.dataset.ready = "";
</script>"""
# What viser's page has, of which the frame's styles are made.
_LIGHT: Final = {
    "--mantine-color-body": "#fff",
    "--mantine-color-text": "#000",
    "--mantine-color-dimmed": "#495057",
    "--mantine-color-default": "#fff",
    "--mantine-color-default-border": "#ced4da",
    "--mantine-color-default-hover": "#f8f9fa",
    "--mantine-primary-color-filled": "#1864ab",
    "--pounce-link": "#1864ab",
}
_DARK: Final = {
    "--mantine-color-body": "#242424",
    "--mantine-color-text": "#c9c9c9",
    "--mantine-color-dimmed": "#b8b8b8",
    "--mantine-color-default": "#2e2e2e",
    "--mantine-color-default-border": "#424242",
    "--mantine-color-default-hover": "#3b3b3b",
    "--mantine-primary-color-filled": "#1971c2",
    "--pounce-link": "#74c0fc",
}


class Taught:
    """A page with a card, by what a person does there."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.complaints: list[str] = []
        page.on("console", self._note)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.route(f"{ORIGIN}/**", serve)

    def _note(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.complaints.append(message.text)

    def open(self, dark: bool = False, zoom: float = 1.0) -> None:
        """Go to the page, which knows nothing yet."""
        self.page.goto(f"{ORIGIN}/lesson/secret/")
        looks = {**(_DARK if dark else _LIGHT), "--stage-zoom": f"{zoom:g}"}
        looks["--mantine-font-family"] = "system-ui, sans-serif"
        self.page.locator("html[data-ready]").wait_for()
        self.page.evaluate(
            """([looks, scheme]) => {
                const root = document.documentElement;
                root.setAttribute("data-mantine-color-scheme", scheme);
                for (const [name, value] of Object.entries(looks))
                    root.style.setProperty(name, value);
                root.style.background = looks["--mantine-color-body"];
            }""",
            [looks, "dark" if dark else "light"],
        )

    def hear(self, state: dict[str, Any]) -> None:
        """Be told a state, and wait until it is shown."""
        self.page.evaluate(
            """async state => {
                window.hear(state);
                for (let frame = 0; frame < 2; frame++)
                    await new Promise(done => requestAnimationFrame(done));
            }""",
            state,
        )

    @property
    def said(self) -> list[dict[str, Any]]:
        """What the page has said since it was last asked for."""
        said: list[dict[str, Any]] = self.page.evaluate("window.sent.splice(0)")
        return said


def serve(route: Route) -> None:
    """Answer for the page of a card and what it loads."""
    path = urlsplit(route.request.url).path
    if path == "/lesson/secret/":
        document = (_WEB / "lesson" / "index.html").read_text("utf-8")
        assert _FRAME in document
        route.fulfill(body=document.replace(_FRAME, _SINK), content_type="text/html")
        return
    file = _WEB / path.removeprefix("/web/")
    if path.startswith("/web/") and file.is_file():
        route.fulfill(body=file.read_bytes(), content_type=_KINDS[file.suffix])
    else:
        route.fulfill(status=404)
