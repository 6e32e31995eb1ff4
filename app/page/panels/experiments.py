"""The *Experiments* tab that all browsers share: choose, see the cost, start, pause, stop."""

import json
import textwrap
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from typing import Final, NamedTuple

import viser

from app.documents import experiments
from app.documents.experiment_spec import MAX_LABEL
from app.documents.experiments import Experiment, ExperimentError
from app.documents.presets import dump
from app.experiments.runner import Progress
from app.experiments.store import FolderError
from app.explain.called import run_on_board
from app.live.requests import GoBack
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.inbox import Ask, Intent, Work
from app.page.number_field import Limits, NumberField
from app.page.panels.file_tab import safe_name
from app.page.widgets import CALM, Choice, assign
from app.results.service import BusyError, Quote, Service, Standing
from app.schedule import carried
from app.server.callbacks import RefusedError
from app.server.notices import tell
from app.util.background import Maker
from app.util.html import element, escaped, joined
from app.util.machine import available_cores
from app.words.numbers import counted, duration, in_short, megabytes, speed_in_words

THIS_SESSION: Final = "This session's schedule"
SESSION_NAME: Final = "session"
"""Folder of the results of a session's schedule."""

MOST_RUNS: Final = 10_000
"""Runs of an experiment that is started in the page; the command line takes more."""
MOST_LOADED: Final = 20
"""Experiments that may be loaded into one lab."""

_N_SESSION_SEEDS: Final = 10
N_TEST_SEEDS: Final = 30
"""Of a line of the session that is tried."""
_MAX_WORKERS: Final = 64
_MOST_TOLD: Final = 400
"""Characters of a notification."""
_FRESH_S: Final = 10.0
"""How long a cost holds: others may put runs into the folder, or take some out, and a session that
is past the trials of its preset becomes longer."""

Show = Callable[[viser.ClientHandle], object]
"""Opens the results in a browser."""


def session_experiment(snapshot: Snapshot, n_seeds: int, line: str = "") -> Experiment:
    """The schedule of a session, as it was and is planned, over many seeds.

    It is called as its line is, if one is named; but not where it does not hold all that was done
    there, which that name would promise.

    Where it differs from the preset of its name, that preset is run beside it on the same seeds,
    so that what was done by hand can be seen against what was not: it comes first, as that which
    variants are set against. What a preset cannot repeat is
    said in comments of the file, and by :func:`not_repeated`.

    Raises:
        ExperimentError: it cannot be run.
    """
    spec, left_out = carried.preset_of(snapshot)
    differs = snapshot.preset_spec != spec
    beside = "; beside it, on the same seeds, its preset as it was" if differs else ""
    lines = [f"# {sentence}" for sentence in left_out]
    lines += [f"description: What was done and is planned in this session{beside}.", "presets:"]
    former = f"{snapshot.preset} as it was"[:MAX_LABEL]
    own = "this session" if left_out or line in ("", former) else line[:MAX_LABEL]
    for label, found in [(former, snapshot.preset_spec)] * differs + [(own, spec)]:
        lines += [f"  - label: {json.dumps(label, ensure_ascii=False)}", "    preset:"]
        lines.append(textwrap.indent(dump(found), "      "))
    text = "\n".join(line.rstrip() for line in lines) + "\n"
    return experiments.parse(text, f"{SESSION_NAME}.yaml", None, n_seeds)


def not_repeated(snapshot: Snapshot) -> Sequence[str]:
    """What was done in a session that its schedule does not repeat, in sentences."""
    return carried.preset_of(snapshot).left_out


def about_html(experiment: Experiment, lost: Sequence[str] = ()) -> str:
    """What an experiment is about, and what of a session it will not repeat."""
    if experiment.name == SESSION_NAME:
        about = escaped(experiment.description)
    else:
        file = element("code", f"{experiment.name}.yaml", style="font-size:0.9em;opacity:0.8")
        about = joined([element("b", f"{experiment.title}."), experiment.description, file], " ")
    if not lost:
        return about
    items = joined(element("li", sentence) for sentence in lost)
    style = "margin:0;padding-left:1.2em"
    return joined(
        [about, element("div", "Will not be repeated:"), element("ul", items, style=style)]
    )


def _session_key(snapshot: Snapshot) -> tuple[object, ...]:
    """What the schedule of a session depends on; not its length beyond the plan, which grows."""
    return snapshot.generation, snapshot.control.history, snapshot.preset


@cache
def _shipped() -> Mapping[str, Experiment]:
    """The experiments that come with the lab, by name."""
    return {name: experiments.load(name) for name in experiments.shipped()}


@lru_cache(maxsize=8)
def _experiment_of(name: str, data: bytes | None, n_seeds: int | None) -> Experiment:
    """A shipped experiment, or one that was loaded; large ones take seconds to read."""
    if data is None:
        return experiments.load(name, n_seeds)
    return experiments.parse(data, f"{name}.yaml", None, n_seeds)


def beside_in_words(n_pages: int, playing: bool) -> str:
    """What goes on beside an experiment and takes its share of the cores, in words."""
    if not n_pages:
        return ""
    pages = "this page" if n_pages == 1 else f"{n_pages} pages"
    return f" with {pages} open" + (" and the lab learning" if playing else "")


def cost_html(quote: Quote, seeds: str, beside: str = "") -> str:
    """What an experiment would take, before it is started.

    Args:
        quote: of the experiment.
        seeds: how many each of its variants has, in words.
        beside: what goes on beside it, in words.
    """
    found = quote.plan
    if found.done == found.runs:
        all_runs = f"All {found.runs:,} runs are" if found.runs > 1 else "The run is"
        return f"{all_runs} in <b>{escaped(quote.folder)}</b> already."
    former = ""
    if quote.is_beside_others:
        former = " It is not what was run under that name before, whose results stay."
    are = "is" if found.done == 1 else "are"
    there = f"; {found.done:,} {are} there already" if found.done else ""
    about = "At most about" if found.at_most else "About"
    drawn = f" ({found.drawn:,} drawn at random)" if found.drawn else ""
    return (
        f"<b>{counted(found.runs, 'run')}</b>: {counted(found.variants, 'variant')}{drawn},"
        f" {seeds} each{there}."
        f"<br>{about} <b>{_about(found.seconds)}</b>{beside}: {in_short(found.steps)} steps,"
        f" {megabytes(found.disk_bytes)}, in <b>{escaped(quote.folder)}</b>.{former}"
    )


def progress_html(standing: Standing) -> str:
    """How an experiment stands."""
    name = f"<b>{escaped(standing.experiment.title)}</b>"
    if standing.error:
        error = f'<span style="color:var(--pounce-failed)">{escaped(standing.error)}</span>'
        return f"{name} stopped: {error}"
    found = standing.progress
    if found is None:
        return f"{name}: getting ready …" if standing.running else f"{name}: stopped."
    failed = f", {found.failed:,} failed" if found.failed else ""
    counts = f"{found.done:,} of {counted(found.total, 'run')} done{failed}{_damage(standing)}"
    if not standing.running:
        over = found.done + found.failed == found.total
        end = "" if over else " Stopped; with it chosen, Make the others goes on there."
        return f"{name}: {counts}.{end}"
    if standing.paused:
        return f"{name}: paused, {counts}."
    return f"{name}: {counts}, {found.running:,} running.<br>{_pace(found)}"


def _damage(standing: Standing) -> str:
    """That runs are made again, if any are."""
    if not standing.damaged:
        return ""
    return f" (the arrays of {counted(standing.damaged, 'run')} were damaged or gone: made again)"


def _start_label(quote: Quote) -> str:
    if not quote.plan.done:
        return "Start"
    return "Show these runs" if quote.plan.done == quote.plan.runs else "Make the others"


def _about(seconds: float) -> str:
    """A time that is only roughly known; nothing takes none."""
    return duration(max(seconds, 1.0))


def _pace(found: Progress) -> str:
    left = "" if found.seconds_left is None else f", about {_about(found.seconds_left)} left"
    return f"{speed_in_words(found.steps_per_s)}{left}"


def small(text: str) -> str:
    """A few lines below a widget."""
    return f'<div style="padding:0 0.6em 0.5em;font-size:0.85em;line-height:1.4">{text}</div>'


class _Offer(NamedTuple):
    """What an experiment is about and would take."""

    about: str
    quote: Quote
    seeds: str
    """How many each variant has, in words."""
    beside: tuple[int, bool]
    """How many pages there were, and whether the lab was learning: they take their share."""
    made_s: float
    """When this was found out, by a clock that runs steadily."""

    def is_stale(self, beside: tuple[int, bool], now_s: float) -> bool:
        """Whether it is to be found out again."""
        return beside != self.beside or now_s - self.made_s > _FRESH_S


class ExperimentsPanel:
    """The tab; the render loop calls :meth:`update`."""

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        service: Service,
        ask: Ask,
        work: Work,
        show: Show,
    ) -> None:
        self._session = session
        self._service = service
        self._work = work
        self._show = show
        self._loaded: dict[str, bytes] = {}
        shipped = _shipped()
        self._n_seeds = {name: len(experiment.seeds) for name, experiment in shipped.items()}
        self._n_seeds[THIS_SESSION] = _N_SESSION_SEEDS
        self._offer: Maker[_Offer] = Maker()
        cores = available_cores()
        abouts = (f"{found.title}: {found.description}" for found in shipped.values())
        self._choice: Choice[str] = Choice(
            gui, "Experiment", self._options(), self._choose, hint=" ".join(abouts)
        )
        self._about = gui.add_html("")
        self._seeds = NumberField(
            gui, "Seeds", _N_SESSION_SEEDS, Limits(1, MOST_RUNS), "Runs of each variant"
        )
        self._workers = NumberField(
            gui,
            "At a time",
            max(cores - 1, 1),
            Limits(1, _MAX_WORKERS),
            f"Runs at a time; this machine has {cores} cores, and the lab needs one",
        )
        self._cost = gui.add_html("")
        self._start = gui.add_button("Start", icon=viser.Icon.PLAYER_PLAY)
        self._pause = gui.add_button(
            "Pause", icon=viser.Icon.PLAYER_PAUSE, color=CALM, visible=False
        )
        self._stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, color=CALM, visible=False)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._said = gui.add_html("")
        # Of the browsers that share it some may show them already, so it steps back for all.
        self._results = gui.add_button(
            "Show results", icon=viser.Icon.CHART_DOTS, color=CALM, visible=False
        )
        self._back = gui.add_button(
            "Back", icon=viser.Icon.ARROW_BACK_UP, color=CALM, visible=False
        )
        self._start.on_click(Intent(self._begin))
        self._pause.on_click(Intent(self._pause_or_go_on))
        self._stop.on_click(Intent(lambda _, __: service.stop()))
        self._results.on_click(Intent(lambda client, _: show(client)))
        self._back.on_click(Intent(lambda client, _: ask(client, GoBack())))

    def take(self, found: Experiment, data: bytes, name: str) -> str:
        """Add an experiment that somebody loaded, and choose it; returns what it is called.

        Args:
            found: the experiment.
            data: its file.
            name: of the file.

        Raises:
            RefusedError: there are too many.
        """
        # A folder is named after it, and two options of a list may not be called the same.
        label = safe_name(name)
        if label in experiments.shipped():
            label = f"{label}_loaded"
        if label not in self._loaded and len(self._loaded) >= MOST_LOADED:
            raise RefusedError(f"{MOST_LOADED} experiments are loaded; more are not kept")
        self._loaded[label] = data
        self._n_seeds[label] = len(found.seeds)
        self._choice.offer(self._options())
        self._choice.choose(label)
        self._seeds.put(len(found.seeds))
        return label

    def update(self, status: Status, n_pages: int) -> None:
        """Show what is true, to so many pages."""
        self._show_cost(status, (n_pages, status.playing))
        assign(self._back, "visible", not status.is_own and status.aside is not None)
        assign(self._back, "label", f"Back to {status.aside}")
        standing = self._service.standing
        running = standing is not None and standing.running
        assign(self._start, "visible", not running and not self._is_shown_whole(standing))
        assign(self._pause, "visible", running)
        assign(self._stop, "visible", running)
        assign(self._results, "visible", standing is not None)
        if standing is None:
            return
        assign(self._results, "label", f"Show results of {standing.experiment.title}")
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
        if standing is None or not isinstance(offer, _Offer):
            return False
        quote = offer.quote
        n_shown = len(standing.gatherer.gathering().runs)
        return quote.folder == standing.folder and quote.plan.done == quote.plan.runs == n_shown

    def _options(self) -> dict[str, str]:
        shipped = {experiments.titled(name): name for name in experiments.shipped()}
        return {THIS_SESSION: THIS_SESSION, **shipped, **{name: name for name in self._loaded}}

    def _experiment(
        self, name: str, n_seeds: int, snapshot: Snapshot, line: str = ""
    ) -> Experiment:
        if name == THIS_SESSION:
            found = session_experiment(snapshot, n_seeds, line)
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
        return _experiment_of(name, self._loaded.get(name), n_seeds)

    def _choose(self, client: viser.ClientHandle, name: str) -> None:
        self._seeds.put(self._n_seeds[name])

    def _show_cost(self, status: Status, beside: tuple[int, bool]) -> None:
        snapshot = status.snapshot
        name, typed = self._choice.chosen, (self._seeds.text, self._workers.text)
        standing = self._service.standing
        is_running = standing is not None and standing.running
        # What is made last may have begun and ended between two frames: its gatherer tells.
        made_last = None if standing is None else standing.gatherer
        of = (name, typed, is_running, made_last, self._loaded.get(name))
        if name == THIS_SESSION:
            of += _session_key(snapshot)

        def offer() -> _Offer:
            experiment = self._experiment(name, int(self._seeds.read()), snapshot)
            lost = not_repeated(snapshot) if name == THIS_SESSION else ()
            found = self._service.quote(experiment, int(self._workers.read()), beside)
            about = about_html(experiment, lost)
            return _Offer(about, found, experiment.seeds_in_words, beside, time.monotonic())

        found_of, found = self._offer.latest
        is_of_this = isinstance(found_of, tuple) and found_of[0] == of
        after = found_of[1] if isinstance(found_of, tuple) and is_of_this else None
        if is_of_this and isinstance(found, _Offer) and not is_running:
            # What is known is shown until it is known better.
            after = found.made_s if found.is_stale(beside, time.monotonic()) else after
        self._offer.want((of, after), offer)
        about, cost, start = "", "Trying a few of these runs, to see how long they take …", "Start"
        if is_of_this and isinstance(found, Exception):
            cost = f"Cannot be run: {escaped(str(found))}"
        elif is_of_this and isinstance(found, _Offer):
            about = found.about
            cost = cost_html(found.quote, found.seeds, beside_in_words(*found.beside))
            start = _start_label(found.quote)
        if name == THIS_SESSION and not status.is_own:
            aside = (
                f", and not of your run ({status.aside}), which is set aside"
                if status.aside
                else ""
            )
            whose = f"{run_on_board(status)}, which is on the board{aside}"
            about = f"<b>This is the schedule of {escaped(whose)}.</b> {about}"
        assign(self._start, "label", start)
        # While it is made, its own progress says more, and what is measured now says less.
        assign(self._cost, "visible", not is_running)
        assign(self._about, "content", small(about))
        assign(self._cost, "content", small(cost))

    def test(self, client: viser.ClientHandle, snapshot: Snapshot, line: str) -> None:
        """Run what was done in a line of the session up to a moment, and is planned, over seeds.

        The results open in that browser. To be called in the render loop.

        Args:
            client: the browser that wants it.
            snapshot: the moment, where what is known of the line ends.
            line: what the line is called.

        Raises:
            RefusedError: the number of runs at a time is none.
        """
        self._run(client, THIS_SESSION, N_TEST_SEEDS, snapshot, line)
        lost = not_repeated(snapshot)
        if lost:
            tell(client, "Not all of it is repeated", " ".join(lost)[:_MOST_TOLD])

    def _begin(self, client: viser.ClientHandle, _: object) -> None:
        name, snapshot = self._choice.chosen, self._session.status.snapshot
        self._run(client, name, int(self._seeds.read()), snapshot)

    def _run(
        self,
        client: viser.ClientHandle,
        name: str,
        n_seeds: int,
        snapshot: Snapshot,
        line: str = "",
    ) -> None:
        workers = int(self._workers.read())

        def begin() -> None:
            try:
                self._service.start(self._experiment(name, n_seeds, snapshot, line), workers)
            except (BusyError, ExperimentError, FolderError) as error:
                raise RefusedError(str(error)) from error

        self._work(client, begin, lambda _: self._show(client))

    def _pause_or_go_on(self, *_: object) -> None:
        standing = self._service.standing
        if standing is not None and standing.paused:
            self._service.go_on()
        else:
            self._service.pause()
