"""The results of an experiment in one browser: chart, table, downloads, and the way to each run."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple

import viser

from app.charts.downloads import drawing_of, numbers_of
from app.charts.page.results import results_html
from app.charts.page.svg import Address, frame_html, link
from app.charts.paper.drawing import missing_note
from app.charts.view import Size, View, answer, first_view
from app.experiments.store import FolderError, table_csv
from app.live.requests import OpenRun
from app.page.inbox import Ask, Inbox
from app.page.panels.experiments import progress_html
from app.page.slots import slot_html
from app.page.widgets import add_buttons, assign
from app.results.gather import Gatherer, Gathering, PlacedRun
from app.results.service import Service, Standing
from app.server.callbacks import RefusedError
from app.server.calls import Calls, address_of
from app.util import csv_texts
from app.util.background import Maker
from app.util.html import element, escaped
from app.util.texts import as_text
from app.words.numbers import counted

_USUAL: Final = Size(684.0, 752.0)
"""Before a page has told how much room there is (``app/web/results.js``)."""
_ROOM: Final = re.compile("([0-9]{1,5})x([0-9]{1,5})")
_LEAST, _MOST = Size(320.0, 300.0), Size(2_400.0, 2_400.0)
_MARGINS = 34.0
"""What the panel's frame and the space within take of its width."""
_SIZE, _SHOW, _CLOSE = "size", "show", "close"
"""What a page calls by itself, and what its links call."""
_SHEET: Final = "spreadsheet.csv"
_REFRESH_S, _LATER_REFRESH_S, _LATER_S = 1.0, 3.0, 10.0
"""How often the content may be replaced, at first and later: a click is lost whose link is replaced
beneath it."""


class _Wish(NamedTuple):
    """What a content is of."""

    gatherer: Gatherer
    n_runs: int
    view: View
    size: Size
    state: tuple[bool, bool, str]
    """Whether it runs and waits, and what stopped it."""


class _Painted(NamedTuple):
    """What is shown of the results, and of how many runs it is."""

    content: str
    done: int
    failed: int


def calls_html(address: Address) -> str:
    """A hidden element with what the page's script calls: how much room there is, and to open."""
    sizes = {"data-results-size": address(f"{_SIZE}/"), "data-results-open": address(_SHOW)}
    return str(element("div", "", hidden="", **sizes))


def room_of(text: str, former: Size) -> Size:
    """The size of the panel that a page tells, in CSS pixels; what is no size changes nothing."""
    found = _ROOM.fullmatch(text)
    if found is None:
        return former
    sides = (
        min(max(float(n), low), high)
        for n, low, high in zip(found.groups(), _LEAST, _MOST, strict=True)
    )
    return Size(*sides)


def sign_html(standing: Standing | None, address: Address) -> str:
    """That an experiment is being made, wherever one looks; empty while none is."""
    if standing is None or not standing.running:
        return ""
    found = standing.progress
    counts = (
        "getting ready" if found is None else f"{found.done:,} of {counted(found.total, 'run')}"
    )
    paused = ", paused" if standing.paused else ""
    shown = link(address, _SHOW, "Show results")
    return f"Experiment {escaped(standing.experiment.title)}: {counts}{paused}. {shown}"


def standing_with(standing: Standing, done: int, failed: int) -> Standing:
    """How an experiment stands for somebody who is shown so many of its runs.

    Runs that are over and not shown yet are about to be, so to them it is not over.
    """
    if standing.progress is None:
        return standing
    lags = len(standing.gatherer.gathering().runs) > done + failed
    progress = standing.progress._replace(done=done, failed=failed)
    return replace(standing, progress=progress, running=standing.running or lags)


class ResultsPanel:
    """The panel; the render loop calls :meth:`update`."""

    def __init__(
        self,
        client: viser.ClientHandle,
        calls: Calls,
        service: Service,
        ask: Ask,
        inbox: Inbox,
        wake: Callable[[], object],
    ) -> None:
        """``wake`` lets the render loop draw at once."""
        self._client = client
        self._calls = calls
        self._service = service
        self._ask = ask
        self._inbox = inbox
        self._view: View | None = None
        self._of: Standing | None = None
        self._size = _USUAL
        self._wake = wake
        self._painted: Maker[_Painted] = Maker(made=wake)
        self._painted_at = self._since_s = 0.0
        self._secret = calls.enter(lambda words: inbox.put(partial(self._called, words)))
        gui = client.gui
        gui.add_html(f"{calls_html(self._address)}{frame_html()}")
        self._sign = gui.add_html(slot_html("experiment", ""))
        self._panel = gui.add_panel(visible=False)
        self._panel.float(x=0.0, y=0.0, width=_USUAL.width, height=_USUAL.height)
        with self._panel.add_tab("Results", icon=viser.Icon.CHART_DOTS):
            self._said = gui.add_html("")
            self._content = gui.add_html("")
            plain = {
                "Runs as CSV": partial(self._send_runs, "csv"),
                "Chart as CSV": partial(self._send_chart, "csv"),
                "Chart as PNG": partial(self._send_chart, "png"),
            }
            sheets = {
                "Runs for spreadsheets": partial(self._send_runs, _SHEET),
                "Chart for spreadsheets": partial(self._send_chart, _SHEET),
            }
            hint = "CSV that a spreadsheet opens with all characters, and no text as a formula"
            add_buttons(gui, "", plain, lambda _, act: act())
            add_buttons(gui, "", sheets, lambda _, act: act(), hint=hint)
            gui.add_html(frame_html() + '<div class="pounce-window"></div>')

    def open(self) -> None:
        """Show the panel, folded out."""
        self._panel.visible = True
        self._panel.expand()

    def leave(self) -> None:
        """Answer no more calls of this browser."""
        self._calls.leave(self._secret)

    def update(self, now_s: float) -> None:
        """Show what is true, as long as it is to be seen."""
        standing = self._service.standing
        assign(self._sign, "content", slot_html("experiment", sign_html(standing, self._address)))
        if standing is None or not self._panel.visible:
            return
        view = self._follow(standing, now_s)
        self._show(standing, now_s)
        gatherer, size = standing.gatherer, self._size
        gathering = gatherer.gathering()
        state = standing.running, standing.paused, standing.error
        of = _Wish(gatherer, len(gathering.runs), view, size, state)
        if not self._is_due(of, standing, now_s):
            return
        inside = size._replace(width=size.width - _MARGINS)
        self._painted.want(
            of,
            lambda: painted(gatherer, gathering, view, self._address, inside),
        )

    def _show(self, standing: Standing, now_s: float) -> None:
        """Show what is painted, and above it how the experiment stands with as many runs."""
        of, found = self._painted.latest
        content = ""
        if not isinstance(of, _Wish) or of.gatherer is not standing.gatherer:
            pass
        elif isinstance(found, _Painted):
            standing = standing_with(standing, found.done, found.failed)
            content = f'<div style="padding:0 0.9em">{found.content}</div>'
        elif isinstance(found, Exception):
            problem = escaped(f"{type(found).__name__}: {found}")
            content = f'<div style="padding:0.9em">{problem}</div>'
        close = link(self._address, _CLOSE, "Close\N{NO-BREAK SPACE}×")
        said = f'<div class="pounce-said"><span>{progress_html(standing)}</span>{close}</div>'
        if self._said.content != said:
            self._said.content = said
        if self._content.content != content:
            self._content.content = content
            self._painted_at = now_s

    def _is_due(self, of: _Wish, standing: Standing, now_s: float) -> bool:
        """Whether the content is to be replaced; for nothing but more runs, only now and then."""
        last, _ = self._painted.latest
        if not isinstance(last, _Wish) or not last.n_runs:
            return True
        if last._replace(n_runs=of.n_runs) != of or of.n_runs == standing.experiment.n_runs:
            return True
        is_new = now_s - self._since_s < _LATER_S
        return now_s - self._painted_at >= (_REFRESH_S if is_new else _LATER_REFRESH_S)

    def _follow(self, standing: Standing, now_s: float) -> View:
        """What is looked at; of another experiment, what one looks at first."""
        of, view = self._of, self._view
        if view is None or of is None or of.gatherer is not standing.gatherer:
            self._view = view = first_view(standing.experiment)
            self._since_s = now_s
        self._of = standing
        return view

    def _address(self, words: str) -> str:
        return address_of(self._secret, words)

    def _called(self, words: str) -> None:
        """A link was clicked, or the page tells of its room; it comes from the network."""
        verb, _, key = words.partition("/")
        if verb == _SIZE:
            self._size = room_of(key, self._size)
            self._wake()
        elif verb == _SHOW and self._service.standing is not None:
            self.open()
            self._wake()
        elif verb == _CLOSE:
            self._close()
        else:
            self._called_on(verb, key, words)

    def _called_on(self, verb: str, key: str, words: str) -> None:
        """A link of what is shown was clicked."""
        if self._of is None or self._view is None:
            return
        if verb == "open":
            self._open_run(self._of, key)
            return
        gathering = self._of.gatherer.gathering()
        self._view = answer(self._view, words, gathering, self._size.rows)
        self._wake()

    def _open_run(self, standing: Standing, key: str) -> None:
        runs = standing.gatherer.gathering().runs
        found = next((placed for placed in runs if placed[1].key == key and placed[1].digest), None)
        if found is not None:
            self._ask(self._client, opened(standing, found))
            self._close()

    def _close(self) -> None:
        self._panel.visible = False

    def _send_runs(self, ending: str) -> None:
        folder = self._shown()[0].folder

        def table() -> bytes:
            try:
                return table_csv(folder, ending == _SHEET).encode()
            except FolderError as error:
                raise RefusedError(str(error)) from error

        name = f"{as_text(folder.name)}_runs.{ending}"
        self._inbox.work(self._client, table, partial(self._send, name))

    def _send_chart(self, ending: str) -> None:
        standing, view = self._shown()
        gatherer = standing.gatherer
        gathering = gatherer.gathering()

        def draw() -> tuple[bytes, str]:
            if ending == "png":
                drawing = drawing_of(gatherer, gathering, view)
                return drawing.png, missing_note(drawing.missing)
            text_of = csv_texts.for_spreadsheets if ending == _SHEET else csv_texts.for_programs
            return text_of(numbers_of(gatherer, gathering, view)).encode(), ""

        def send(drawn: tuple[bytes, str]) -> None:
            data, note = drawn
            name = as_text(standing.folder.name)
            self._send(f"{name}_chart_{view.chart}.{ending}", data)
            if note:
                self._client.add_notification("Saved, with boxes", note, auto_close_seconds=10.0)

        self._inbox.work(self._client, draw, send)

    def _shown(self) -> tuple[Standing, View]:
        """What is shown, of which another experiment may have taken the place that runs now.

        Raises:
            RefusedError: it has no run yet.
        """
        if self._of is None or self._view is None or not self._of.gatherer.gathering().runs:
            raise RefusedError("no run is over yet")
        return self._of, self._view

    def _send(self, name: str, data: bytes) -> None:
        self._client.send_file_download(name, data, save_immediately=True)


def painted(
    gatherer: Gatherer, gathering: Gathering, view: View, address: Address, size: Size
) -> _Painted:
    """The results as they are shown."""
    failed = sum(1 for _, run in gathering.runs if run.error)
    content = results_html(gatherer, gathering, view, address, size)
    return _Painted(content, len(gathering.runs) - failed, failed)


def opened(standing: Standing, placed: PlacedRun) -> OpenRun:
    """The request that makes a run of an experiment again."""
    place, run = placed
    variant = standing.experiment.variants[place]
    called = f"{standing.experiment.title}: {variant.label}"
    return OpenRun(
        variant.spec,
        called,
        run.seed,
        run.steps,
        run.digest,
        f"{called}, seed {run.seed}",
    )
