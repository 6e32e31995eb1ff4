"""The *Experiments* tab that all browsers share: choose, see the cost, start, pause, stop.

As with the other controls, a callback asks and the render loop shows what is true.
"""

import os
import textwrap
import threading
from collections.abc import Callable
from html import escape
from typing import Any, Final

import viser

from app import experiments, timeline
from app.background import Maker
from app.door import RefusedError, guarded
from app.experiments import Experiment, ExperimentError
from app.laboratory import Progress
from app.planner import safe_name
from app.presets import dump, load, shipped
from app.results import FolderError
from app.session import Session, Status
from app.snapshot import Snapshot
from app.widgets import assign, on_change
from app.workbench import BusyError, Quote, Standing, Workbench

THIS_SESSION: Final = "This session's schedule"
SESSION_NAME: Final = "session"
"""Folder of the results of a session's schedule."""

MOST_RUNS: Final = 10_000
"""Runs of an experiment that is started in the page; the command line takes more."""
MOST_LOADED: Final = 20
"""Experiments that may be loaded into one lab."""

_N_SESSION_SEEDS: Final = 10
_MAX_WORKERS: Final = 64

Show = Callable[[viser.ClientHandle], object]
"""Opens the results in a browser."""


def session_experiment(snapshot: Snapshot, n_seeds: int) -> Experiment:
    """The schedule of a session, as it was and is planned, over many seeds.

    Where it differs from the preset of its name, that preset is run beside it on the same seeds,
    so that what was done by hand can be seen against what was not.

    Raises:
        ExperimentError: it cannot be run.
    """
    spec, _ = timeline.preset_of(snapshot)
    differs = snapshot.preset in shipped() and load(snapshot.preset) != spec
    beside = f"; beside it, on the same seeds, {snapshot.preset} as it was" if differs else ""
    lines = [f"description: What was done and is planned in this session{beside}.", "presets:"]
    lines += ["  - label: this session", "    preset:", textwrap.indent(dump(spec), "      ")]
    if differs:
        lines.append(f"  - {snapshot.preset}")
    text = "\n".join(line.rstrip() for line in lines) + "\n"
    return experiments.parse(text, f"{SESSION_NAME}.yaml", None, n_seeds)


def duration(seconds: float) -> str:
    """A time in words that are short."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"


def cost_html(quote: Quote, n_seeds: int) -> str:
    """What an experiment would take, before it is started."""
    found = quote.plan
    left = found.runs - quote.done
    if not left:
        return f"All {found.runs:,} runs are in <b>{escape(str(quote.folder))}</b> already."
    share = left / found.runs
    there = f"; {quote.done:,} are there already" if quote.done else ""
    return (
        f"<b>{_counted(found.runs, 'run')}</b>: {_counted(found.variants, 'variant')},"
        f" {_counted(n_seeds, 'seed')} each{there}."
        f"<br>About {_steps(found.steps * share)} steps, <b>{duration(found.seconds * share)}</b>,"
        f" {max(found.disk_bytes * share / 1e6, 0.1):,.1f} MB, in"
        f" <b>{escape(str(quote.folder))}</b>."
    )


def progress_html(standing: Standing) -> str:
    """How an experiment stands."""
    name = f"<b>{escape(standing.experiment.name)}</b>"
    if standing.error:
        return f'{name} stopped: <span style="color:#e03131">{escape(standing.error)}</span>'
    found = standing.progress
    if found is None:
        return f"{name}: getting ready …"
    failed = f", {found.failed:,} failed" if found.failed else ""
    counts = f"{found.done:,} of {found.total:,} runs done{failed}"
    if not standing.running:
        over = found.done + found.failed == found.total
        end = "" if over else " Stopped; start it again to go on there."
        return f"{name}: {counts}.{end}"
    if standing.paused:
        return f"{name}: paused, {counts}."
    return f"{name}: {counts}, {found.running:,} running.<br>{_pace(found)}"


def _start_label(quote: Quote) -> str:
    if not quote.done:
        return "Start"
    return "Show these runs" if quote.done == quote.plan.runs else "Make the others"


def _counted(number: int, what: str) -> str:
    return f"{number:,} {what}" if number == 1 else f"{number:,} {what}s"


def _pace(found: Progress) -> str:
    left = "" if found.seconds_left is None else f", about {duration(found.seconds_left)} left"
    return f"{found.steps_per_s / 1e6:.0f} M steps/s{left}"


def _steps(number: float) -> str:
    return f"{number / 1e6:,.0f} M" if number >= 1e6 else f"{number:,.0f}"


def small(text: str) -> str:
    """A few lines below a widget."""
    return f'<div style="padding:0 0.6em 0.5em;font-size:0.85em;line-height:1.4">{text}</div>'


class Experimenter:
    """The tab; the render loop calls :meth:`update`."""

    def __init__(self, gui: viser.GuiApi, session: Session, bench: Workbench, show: Show) -> None:
        self._session = session
        self._bench = bench
        self._show = show
        self._lock = threading.Lock()
        self._loaded: dict[str, bytes] = {}
        self._n_seeds = {name: len(experiments.load(name).seeds) for name in experiments.shipped()}
        self._n_seeds[THIS_SESSION] = _N_SESSION_SEEDS
        self._offer: Maker[tuple[str, Quote]] = Maker()
        cores = os.cpu_count() or 1
        self._choice: Any = gui.add_dropdown("Experiment", self._options())
        self._about = gui.add_html("")
        self._seeds = gui.add_number(
            "Seeds", _N_SESSION_SEEDS, min=1, max=MOST_RUNS, step=1, hint="Runs of each variant"
        )
        self._workers = gui.add_number(
            "At a time",
            max(cores - 1, 1),
            min=1,
            max=_MAX_WORKERS,
            step=1,
            hint=f"Runs at a time; this machine has {cores} cores, and the lab needs one",
        )
        self._cost = gui.add_html("")
        self._start = gui.add_button("Start", icon=viser.Icon.PLAYER_PLAY)
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, visible=False)
        self._stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, visible=False)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._said = gui.add_html("")
        self._results = gui.add_button("Show results", icon=viser.Icon.CHART_DOTS, visible=False)
        # Before whatever is typed into the field of seeds next.
        on_change(self._choice, self._choose)
        self._start.on_click(guarded(self._begin))
        self._pause.on_click(guarded(lambda _: self._pause_or_go_on()))
        self._stop.on_click(guarded(lambda _: self._bench.stop()))
        self._results.on_click(guarded(self._open))

    def take(self, data: bytes, name: str) -> str:
        """Add an experiment that somebody loaded, and choose it; returns what it is called.

        It may name shipped presets or hold presets of its own; no other file is looked at.

        Raises:
            ExperimentError: it cannot be run.
            RefusedError: there are too many.
        """
        found = experiments.parse(data, name, None)
        # A folder is named after it, and two options of a list may not be called the same.
        label = safe_name(name)
        if label in experiments.shipped():
            label = f"{label}_loaded"
        with self._lock:
            if label not in self._loaded and len(self._loaded) >= MOST_LOADED:
                raise RefusedError(f"{MOST_LOADED} experiments are loaded; more are not kept")
            self._loaded[label] = data
            self._n_seeds[label] = len(found.seeds)
        self._choice.options = self._options()
        self._choice.value = label
        self._seeds.value = len(found.seeds)
        return label

    def update(self, status: Status) -> None:
        """Show what is true."""
        self._show_cost(status.snapshot)
        standing = self._bench.standing
        running = standing is not None and standing.running
        assign(self._start, "visible", not running and not self._is_shown_whole(standing))
        assign(self._pause, "visible", running)
        assign(self._stop, "visible", running)
        assign(self._results, "visible", standing is not None)
        if standing is None:
            return
        assign(self._pause, "label", "Go on" if standing.paused else "Pause")
        icon = viser.Icon.PLAYER_PLAY if standing.paused else viser.Icon.PLAYER_PAUSE
        assign(self._pause, "icon", icon)
        share = 0.0 if standing.progress is None else round(100 * standing.progress.share, 1)
        assign(self._bar, "visible", running)
        assign(self._bar, "value", share)
        assign(self._said, "content", small(progress_html(standing)))

    def _is_shown_whole(self, standing: Standing | None) -> bool:
        """Whether what is chosen is what was made last, and nothing of it is missing."""
        offer = self._offer.found
        if standing is None or not isinstance(offer, tuple):
            return False
        quote = offer[1]
        n_shown = len(standing.gatherer.gathering().runs)
        return quote.folder == standing.folder and quote.done == quote.plan.runs == n_shown

    def _options(self) -> tuple[str, ...]:
        return (THIS_SESSION, *experiments.shipped(), *self._loaded)

    def _experiment(self, snapshot: Snapshot) -> Experiment:
        name, n_seeds = str(self._choice.value), int(self._seeds.value)
        if name == THIS_SESSION:
            found = session_experiment(snapshot, n_seeds)
        else:
            found = self._file(name)
            # As many as the file asks for are its own ones, which may be any.
            if len(found.seeds) != n_seeds:
                found = self._file(name, n_seeds)
        if found.n_runs > MOST_RUNS:
            raise RefusedError(
                f"these are {found.n_runs:,} runs; allowed: {MOST_RUNS:,} in the page, and more"
                " with pounce experiment"
            )
        return found

    def _file(self, name: str, n_seeds: int | None = None) -> Experiment:
        """An experiment that was loaded, or a shipped one."""
        if name in self._loaded:
            return experiments.parse(self._loaded[name], f"{name}.yaml", None, n_seeds)
        return experiments.load(name, n_seeds)

    def _choose(self, event: viser.GuiEvent, name: str) -> None:
        self._seeds.value = self._n_seeds.get(name, _N_SESSION_SEEDS)

    def _show_cost(self, snapshot: Snapshot) -> None:
        name, n_seeds = str(self._choice.value), int(self._seeds.value)
        workers = int(self._workers.value)
        standing = self._bench.standing
        of = [name, n_seeds, workers, standing is not None and standing.running]
        if name == THIS_SESSION:
            of += [snapshot.generation, len(snapshot.control.history), snapshot.preset]

        def offer() -> tuple[str, Quote]:
            experiment = self._experiment(snapshot)
            return experiment.description, self._bench.quote(experiment, workers)

        self._offer.want(tuple(of), offer)
        found, is_of_this = self._offer.found, self._offer.found_of == tuple(of)
        about, cost, start = "", "Finding out what it would take …", "Start"
        if is_of_this and isinstance(found, Exception):
            cost = f"Cannot be run: {escape(str(found))}"
        elif is_of_this and isinstance(found, tuple):
            description, quote = found
            about, cost = escape(description), cost_html(quote, n_seeds)
            start = _start_label(quote)
        assign(self._start, "label", start)
        assign(self._about, "content", small(about))
        assign(self._cost, "content", small(cost))

    def _begin(self, event: viser.GuiEvent) -> None:
        try:
            experiment = self._experiment(self._session.status.snapshot)
            self._bench.start(experiment, int(self._workers.value))
        except (BusyError, ExperimentError, FolderError) as error:
            raise RefusedError(str(error)) from error
        if event.client is not None:
            self._show(event.client)

    def _pause_or_go_on(self) -> None:
        standing = self._bench.standing
        if standing is not None and standing.paused:
            self._bench.go_on()
        else:
            self._bench.pause()

    def _open(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._show(event.client)
