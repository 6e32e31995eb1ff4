"""The results of an experiment in one browser: chart, table, downloads, and the way to each run."""

import threading
from collections.abc import Callable
from html import escape
from typing import Final, NamedTuple

import viser

from app import results_view
from app.background import Maker
from app.door import Calls, RefusedError, address_of, guarded
from app.experimenter import progress_html
from app.gathered import RunFact
from app.results import FolderError, table_csv
from app.results_files import drawing_of
from app.results_view import View
from app.session import OpenRun
from app.workbench import Standing, Workbench

CALLS_FRAME: Final = "pounce-calls"
"""Name of the frame that links of the page are aimed at, so that the page stays where it is."""

_X, _Y, _WIDTH, _HEIGHT = 8.0, 8.0, 684.0, 752.0
"""Over the board and the schedule on the smallest screen, over the board alone on others."""
_MARGINS = 34.0
"""What the panel's frame and the space within take of its width."""
_SAID = "padding:0.3em 0.9em 0"
_REFRESH_S, _LATER_REFRESH_S, _LATER_S = 1.0, 3.0, 10.0
"""How often the content may be replaced, at first and later: a click is lost whose link is replaced
beneath it."""
_RUNS_CSV, _CHART_CSV, _CHART_PNG = "Runs as CSV", "Chart as CSV", "Chart as PNG"
_CLOSE = "Close"


class _Wish(NamedTuple):
    """What a content is of."""

    gatherer: int
    n_runs: int
    view: View | None


def frame_html() -> str:
    """The frame that answers to links go into; it stays empty."""
    return f'<iframe name="{CALLS_FRAME}" title="" style="display:none"></iframe>'


class ResultsPanel:
    """The panel; the render loop calls :meth:`update`."""

    def __init__(
        self,
        client: viser.ClientHandle,
        calls: Calls,
        bench: Workbench,
        ask_for: Callable[[viser.ClientHandle, OpenRun], object],
        wake: Callable[[], object],
    ) -> None:
        """``wake`` lets the render loop draw at once."""
        self._client = client
        self._calls = calls
        self._bench = bench
        self._ask_for = ask_for
        self._lock = threading.Lock()
        self._view: View | None = None
        self._of: Standing | None = None
        self._wake = wake
        self._painted: Maker[str] = Maker(made=wake)
        self._painted_at = self._since_s = 0.0
        self._secret = calls.enter(self._called)
        gui = client.gui
        self._panel = gui.add_panel(visible=False)
        self._panel.float(x=_X, y=_Y, width=_WIDTH, height=_HEIGHT)
        with self._panel.add_tab("Results", icon=viser.Icon.CHART_DOTS):
            self._said = gui.add_html("")
            self._content = gui.add_html("")
            self._save = gui.add_button_group("", (_RUNS_CSV, _CHART_CSV, _CHART_PNG, _CLOSE))
            gui.add_html(frame_html())
        self._save.on_click(guarded(self._clicked))

    def open(self) -> None:
        """Show the panel."""
        self._panel.visible = True
        self._panel.expand()

    def leave(self) -> None:
        """Answer no more calls of this browser."""
        self._calls.leave(self._secret)

    def update(self, now_s: float) -> None:
        """Show what is true, as long as it is to be seen."""
        standing = self._bench.standing
        if standing is None or not self._panel.visible:
            return
        self._follow(standing, now_s)
        said = f'<div style="{_SAID}">{progress_html(standing)}</div>'
        if self._said.content != said:
            self._said.content = said
        found = self._painted.found
        if isinstance(found, Exception):
            found = f'<div style="padding:0.9em">{escape(f"{type(found).__name__}: {found}")}</div>'
        elif found is not None:
            found = f'<div style="padding:0 0.9em">{found}</div>'
        if found is not None and self._content.content != found:
            self._content.content = found
            self._painted_at = now_s
        gatherer, view = standing.gatherer, self._view
        gathering = gatherer.gathering()
        of = _Wish(id(gatherer), len(gathering.runs), view)
        if view is None or not self._is_due(of, standing, now_s):
            return
        self._painted.want(
            of,
            lambda: results_view.results_html(
                gatherer, gathering, view, self._address, _WIDTH - _MARGINS
            ),
        )

    def _is_due(self, of: "_Wish", standing: Standing, now_s: float) -> bool:
        """Whether the content is to be replaced; for nothing but more runs, only now and then."""
        last = self._painted.found_of
        if not isinstance(last, _Wish) or not last.n_runs or not standing.running:
            return True
        if (last.gatherer, last.view) != (of.gatherer, of.view):
            return True
        is_new = now_s - self._since_s < _LATER_S
        return now_s - self._painted_at >= (_REFRESH_S if is_new else _LATER_REFRESH_S)

    def _follow(self, standing: Standing, now_s: float) -> None:
        """Look at another experiment as one looks at it first."""
        with self._lock:
            if self._of is None or self._of.gatherer is not standing.gatherer:
                self._view = results_view.first_view(standing.experiment)
                self._since_s = now_s
            self._of = standing

    def _address(self, words: str) -> str:
        return address_of(self._secret, words)

    def _called(self, words: str) -> None:
        """A link was clicked; this runs on the event loop, and at once."""
        with self._lock:
            standing, view = self._of, self._view
        if standing is None or view is None:
            return
        verb, _, key = words.partition("/")
        if verb == "open":
            self._open_run(standing, key)
            return
        changed = results_view.answer(view, words, standing.gatherer.gathering())
        with self._lock:
            # Another experiment may have come in between.
            if self._of is not None and self._of.gatherer is standing.gatherer:
                self._view = changed
        self._wake()

    def _open_run(self, standing: Standing, key: str) -> None:
        runs = standing.gatherer.gathering().runs
        fact = next((run for run in runs if run.key == key and run.digest), None)
        if fact is not None:
            self._ask_for(self._client, opened(standing, fact))
            self._panel.visible = False

    def _clicked(self, event: viser.GuiEvent) -> None:
        chosen, standing, view = str(self._save.value), self._bench.standing, self._view
        if chosen == _CLOSE:
            self._panel.visible = False
            return
        if standing is None or view is None:
            return
        name, gatherer = standing.folder.name, standing.gatherer
        gathering = gatherer.gathering()
        if not gathering.runs:
            raise RefusedError("no run is over yet")
        if chosen == _RUNS_CSV:
            try:
                data = table_csv(standing.folder).encode()
            except FolderError as error:
                raise RefusedError(str(error)) from error
            self._client.send_file_download(f"{name}_runs.csv", data, save_immediately=True)
            return
        drawing = drawing_of(gatherer, gathering, view)
        ending, data = (
            ("csv", drawing.csv.encode()) if chosen == _CHART_CSV else ("png", drawing.png)
        )
        self._client.send_file_download(
            f"{name}_chart_{view.chart}.{ending}", data, save_immediately=True
        )


def opened(standing: Standing, fact: RunFact) -> OpenRun:
    """The request that makes a run of an experiment again."""
    variant = standing.experiment.variants[fact.variant]
    name = f"{standing.experiment.name}: {variant.label}, seed {fact.seed}"
    return OpenRun(
        variant.spec,
        f"{standing.experiment.name}: {variant.label}",
        fact.seed,
        fact.steps,
        fact.digest,
        name,
    )
