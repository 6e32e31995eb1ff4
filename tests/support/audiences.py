"""An audience of a lab with a real port, and what may be sent to it that does nothing."""

import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import msgspec

from app.audience.audience import Audience
from app.page.time.messages import FromFrame
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.player.presented import Presented
from tests.support.live import LiveLab, preset_of
from tests.support.server import CAMERA
from tests.support.watching import Page

FOLLOW = {"do": "follow", "dark": False}
MOMENT: dict[str, Any] = {"line": 0, "step": 0, "trial": 0, "live": True}


class Shown:
    """A lab with an audience, to which the test shows what a presenter sees."""

    def __init__(self, folder: Path, trial: int = 40, sessions: Path | None = None) -> None:
        # Its page knows of no audience, so nobody presents but the test.
        self.live = LiveLab(preset_of(), 20_000.0, folder, sessions=sessions)
        self.audience = Audience(self.live.session.past_of, "127.0.0.1", 0)
        self.pages: list[Page] = []
        if trial:
            self.live.go_to_trial(trial)

    def page(self, wish: dict[str, Any] | None = None) -> Page:
        """One more that looks."""
        page = Page(self.audience.watchers.port)
        self.pages.append(page)
        page.send(wish or FOLLOW)
        return page

    def present(self, look: Look | None = None, **changes: Any) -> Presented:
        """Show that as the presenter's."""
        status = self.live.session.status
        line = status.snapshot.generation
        shown = Presented(
            status,
            look or Look(),
            Extras(),
            msgspec.Raw(b'{"bar":1}'),
            {**MOMENT, "line": line, "step": status.snapshot.step},
        )._replace(**changes)
        self.audience.show(status, shown)
        return shown

    def close(self) -> None:
        for page in self.pages:
            page.close()
        self.audience.close()
        self.live.close()


def hostile_texts() -> Iterator[str | bytes]:
    """All that there is to be sent: every message of the time bar, viser's, and nonsense."""
    values: dict[str, Any] = {
        "step": 3,
        "trial": 3,
        "line": 1,
        "direction": 1,
        "rate": 4.0,
        "unit": "trials",
        "n": -3,
        "on": True,
        "id": "introduction:avoid",
        "at": 50,
        "trials": 20,
        "probability": 0.9,
        "skill": "avoid",
        "text": "<script>alert(1)</script>",
        "number": 1,
        "name": "x",
        "points": [(trial, 0.0) for trial in range(6)],
    }
    for kind in get_args(FromFrame):
        fields = {name: values[name] for name in kind.__struct_fields__}
        yield msgspec.json.encode({"do": kind.__struct_config__.tag, **fields}).decode()
    yield msgspec.msgpack.encode(CAMERA.as_serializable_dict())
    for request in ("Play", "StartAgain", "SetSpeed", "play", "begin"):
        yield msgspec.json.encode({"do": request, "type": request}).decode()
        yield msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": request, "updates": {}})
    chance = random.Random(5)
    for _ in range(100):
        yield chance.randbytes(chance.randrange(200))
    for layer in (*LAYERS, "../../etc/passwd", "\x00"):
        for step in (None, 0, 1, 2**53):
            yield msgspec.json.encode(
                {"do": "look", "dark": True, "layer": layer, "frame": 3, "step": step}
            ).decode()
