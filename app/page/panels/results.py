"""The results of an experiment in one browser: chart, table, downloads, and the way to each run."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple

import viser

from app.charts.downloads import drawing_of, numbers_of
from app.charts.page.results import results_html
from app.charts.page.svg import Address, frame_html
from app.charts.paper.drawing import missing_note
from app.charts.view import Size, View, answer, first_view
from app.experiments.store import FolderError, table_csv
from app.live.session import OpenRun
from app.page.inbox import Ask, Inbox
from app.page.panels.experiments import progress_html
from app.page.widgets import add_buttons
from app.results.gather import Gatherer, Gathering, PlacedRun
from app.results.service import Service, Standing
from app.server.callbacks import RefusedError
from app.server.calls import Calls, address_of
from app.util import csv_texts
from app.util.background import Maker
from app.util.html import escaped
from app.util.texts import as_text

_GAP: Final = 8.0
"""To what is beside the panel."""
_DOCKED: Final = 334.0
"""Width of the panels to the left and to the right of the board."""
_MIDDLE: Final = 2 * (_DOCKED + _GAP)
"""What these panels and the gaps beside them take of a window's width."""
_LEAST_WIDTH, _MOST_WIDTH = 684.0, 1240.0
"""On a small screen it lies over the panel to the left, so that one can still pause and stop."""
_LEAST_HEIGHT, _MOST_HEIGHT = 480.0, 1240.0
_WINDOW_WIDTHS: Final = (1366, 1440, 1536, 1600, 1680, 1760, 1840, 1920)
_WINDOW_HEIGHTS: Final = (560, 640, 700, 768, 800, 860, 900, 960, 1020, 1080, 1200)
"""Sizes of the browser's window that the panel has a size of its own for, in CSS pixels."""
_USUAL_WINDOW: Final = (1366, 768)
_WIDE, _TALL = "wide", "tall"
_MARGINS = 34.0
"""What the panel's frame and the space within take of its width."""
# Where there is less room than that, viser puts the panel beside the left one, and over the right.
_ON_SMALL_SCREENS: Final = f"""<style>@media (max-width: {_MIDDLE + _LEAST_WIDTH - 1:.0f}px) {{
[data-floating-window][style*="left: {_DOCKED:.0f}px"][style*="width: {_LEAST_WIDTH:.0f}px"]:has(
.pounce-window) {{
left: max(0px, calc(100vw - {_DOCKED + _GAP + _LEAST_WIDTH:.0f}px)) !important; }} }}</style>"""
_SAID = "padding:0.3em 0.9em 0"
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


def window_html(address: Address) -> str:
    """Pictures that are not to be seen, and whose addresses tell the lab how large the window is.

    The camera of viser cannot tell: it counts the pixels of the screen, and of the board alone.
    """

    def picture(verb: str, condition: str, sizes: Sequence[int]) -> str:
        sources = "".join(
            f'<source media="({condition}:{size}px)" srcset="{address(f"{verb}/{size}")}">'
            for size in reversed(sizes)
        )
        return f'<picture>{sources}<img src="{address(f"{verb}/0")}" alt=""></picture>'

    pictures = picture(_WIDE, "min-width", _WINDOW_WIDTHS)
    pictures += picture(_TALL, "min-height", _WINDOW_HEIGHTS)
    return f'{_ON_SMALL_SCREENS}<div class="pounce-window" style="display:none">{pictures}</div>'


def panel_size(window: tuple[int, int]) -> Size:
    """The size of the panel in a browser's window of so many pixels, or a little more."""
    width = window[0] - _MIDDLE
    height = window[1] - 2 * _GAP
    return Size(
        min(max(width, _LEAST_WIDTH), _MOST_WIDTH), min(max(height, _LEAST_HEIGHT), _MOST_HEIGHT)
    )


def resized(window: tuple[int, int], verb: str, pixels: str) -> tuple[int, int]:
    """The size of a window after one of its pictures was asked for; what is no size is nothing."""
    sizes = _WINDOW_WIDTHS if verb == _WIDE else _WINDOW_HEIGHTS
    found = next((size for size in (0, *sizes) if str(size) == pixels), None)
    if found is None:
        return window
    return (found, window[1]) if verb == _WIDE else (window[0], found)


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
        self._window = _USUAL_WINDOW
        self._placed: Size | None = None
        self._wake = wake
        self._painted: Maker[_Painted] = Maker(made=wake)
        self._painted_at = self._since_s = 0.0
        self._secret = calls.enter(lambda words: inbox.put(partial(self._called, words)))
        gui = client.gui
        self._panel = gui.add_panel(visible=False)
        self._place()
        with self._panel.add_tab("Results", icon=viser.Icon.CHART_DOTS):
            self._said = gui.add_html("")
            self._content = gui.add_html("")
            plain = {
                "Runs as CSV": partial(self._send_runs, "csv"),
                "Chart as CSV": partial(self._send_chart, "csv"),
                "Chart as PNG": partial(self._send_chart, "png"),
                "Close": self._close,
            }
            sheets = {
                "Runs for spreadsheets": partial(self._send_runs, _SHEET),
                "Chart for spreadsheets": partial(self._send_chart, _SHEET),
            }
            hint = "CSV that a spreadsheet opens with all characters, and no text as a formula"
            add_buttons(gui, "", plain, lambda _, act: act())
            add_buttons(gui, "", sheets, lambda _, act: act(), hint=hint)
            gui.add_html(frame_html() + window_html(self._address))

    def open(self) -> None:
        """Show the panel; one that is shown comes back to its place."""
        if self._panel.visible:
            self._placed = None
            self._place()
        self._panel.visible = True
        self._panel.expand()

    def leave(self) -> None:
        """Answer no more calls of this browser."""
        self._calls.leave(self._secret)

    def update(self, now_s: float) -> None:
        """Show what is true, as long as it is to be seen."""
        standing = self._service.standing
        if standing is None or not self._panel.visible:
            return
        view = self._follow(standing, now_s)
        self._place()
        self._show(standing, now_s)
        gatherer, size = standing.gatherer, panel_size(self._window)
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

    def _place(self) -> None:
        """Have the panel where it belongs in a window of this size."""
        size = panel_size(self._window)
        if size != self._placed:
            self._placed = size
            self._panel.float(x=-_GAP, y=_GAP, width=size.width, height=size.height)

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
        said = f'<div style="{_SAID}">{progress_html(standing)}</div>'
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
        """A link was clicked, or a window has its size."""
        verb, _, key = words.partition("/")
        if verb in (_WIDE, _TALL):
            self._window = resized(self._window, verb, key)
            self._wake()
            return
        if self._of is None or self._view is None:
            return
        if verb == "open":
            self._open_run(self._of, key)
            return
        rows = panel_size(self._window).rows
        self._view = answer(self._view, words, self._of.gatherer.gathering(), rows)
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
