"""What one connected browser is shown; what it steers is shared by all, in the lab."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import viser

from app.live.session import Session
from app.live.status import Status
from app.page.arrival import Arrival
from app.page.inbox import Ask, Inbox, Intent, StatusOf
from app.page.lesson.board import ROOT as ASKED
from app.page.lesson.board import BoardAsk
from app.page.lesson.desk import Desk
from app.page.lesson.does import run_shipped
from app.page.lesson.marked import ROOT as MARKED
from app.page.lesson.marked import Marked
from app.page.lesson.panel import LessonPanel
from app.page.lesson.sitter import Rooms
from app.page.panels.audience import Audience
from app.page.panels.earlier import Earlier
from app.page.panels.export import Export
from app.page.panels.export import Seen as OnBoard
from app.page.panels.file_tab import FileTab, OfferPreset, TakeExperiment
from app.page.panels.hunts import Hunts
from app.page.panels.inspection import Inspection, cell_under
from app.page.panels.readings import Readings
from app.page.panels.results import ResultsPanel
from app.page.panels.share import Share
from app.page.presenting import Presenting
from app.page.scene.gallery import Exhibit, Seen
from app.page.side.panel import Presets, SidePanel
from app.page.side.show import SideShow
from app.page.time.asks import Asks, Submit
from app.page.time.bars import Bars
from app.page.time.outlook import Outlook
from app.page.time.panel import Deeds, TimePanel
from app.page.time.rise import rise_under
from app.page.widgets import assign
from app.picture.layer import Extras
from app.picture.layers.change import CHANGE
from app.picture.layers.reach import REACH
from app.picture.look import ALL, Look
from app.player.texts import Texts
from app.results.service import Service
from app.server.calls import Calls
from app.server.channels import Channels
from app.server.links import Links
from app.server.pulse import Pulse


class Shared(NamedTuple):
    """What all browsers of a lab have in common."""

    server: viser.ViserServer
    session: Session
    calls: Calls
    channels: Channels
    links: Links
    bars: Bars
    deeds: Deeds
    """What the time bar can have done."""
    service: Service
    inbox: Inbox
    ask: Ask
    """For whatever a browser asks, which means the moment that it looks at."""
    status_of: StatusOf
    """What is true for a browser now."""
    submit: Submit
    """Hands a request to the session."""
    wake: Callable[[], None]
    """Lets the render loop draw at once."""
    drawn: Callable[[], None]
    """Called whenever a page has drawn its first picture of the board."""
    take_experiment: TakeExperiment
    offer_preset: OfferPreset
    save_dir: Path | None
    """Where presets may be saved, if anywhere."""
    sessions: Path | None
    """Where sessions are kept, if anywhere."""
    n_viewers: Callable[[], int]
    """Browsers that there are."""
    side: SideShow
    """Shows runs side by side."""
    presets: Presets
    """Those that runs may be of."""
    presenting: Presenting
    """Who shows an audience what they see."""
    desk: Desk
    """Knows the lessons, and which of them is on."""


class Browser:
    """The panels of one browser, and which frame of which board it was sent last."""

    def __init__(self, shared: Shared, client: viser.ClientHandle) -> None:
        ask, inbox, wake = shared.ask, shared.inbox, shared.wake
        self.client = client
        self.outlook = Outlook(client.client_id, shared.session.moments)
        """What it looks at."""
        self.asks = Asks(self.outlook, shared.submit, inbox.put)
        """What it asks for."""
        self._shared = shared
        arrival = Arrival(
            client,
            shared.session,
            shared.submit,
            inbox.work,
            shared.n_viewers,
            shared.sessions,
            shared.links,
        )
        self.readings = Readings(
            client, shared.session.status, shared.calls, inbox, shared.drawn, arrival.came
        )
        self._hunts = Hunts(client, ask, shared.calls, inbox, wake)
        self.time = TimePanel(
            client,
            self.outlook,
            self.asks,
            shared.channels,
            shared.bars,
            inbox,
            shared.deeds,
            wake,
        )
        """The bar, by which it goes through time."""
        self.side = SidePanel(
            client, shared.session, shared.side, shared.channels, inbox, shared.presets
        )
        """Runs side by side, where this browser looks at them in the place of the board."""
        self.pulse = Pulse(shared.server, client.client_id)
        self.exhibit: Exhibit | None = None
        """Of what it was sent a frame last, and so what is on its screen, whatever it is to see by
        now; None before the first."""
        self._sent = 0
        self._extras = Extras()
        self._wake = wake
        # What is drawn for this browser alone is drawn on a whole board.
        self._drawn_alone = [
            client.scene.add_frame(name, show_axes=False)
            for name in ("/inspect", "/watched", ASKED, MARKED)
        ]
        self._inspection = Inspection(client, self.readings.inspect_tab, wake)
        self.octants = BoardAsk(client, wake)
        """What it is asked about the octants round the prey."""
        presenting, stand = shared.presenting, shared.presenting.stand
        rooms = Rooms(
            view=self.readings.view,
            outlook=self.outlook,
            asks=self.asks,
            time=self.time,
            octants=self.octants,
            marked=Marked(client),
            inspection=self._inspection,
            open_side=self.side.open,
            watch=self._hunts.watch,
            experiment=self._experiment,
            presents=lambda: stand is not None and presenting.presenter == client.client_id,
            classroom=None if stand is None else stand.classroom,
        )
        self.lesson = LessonPanel(
            client, shared.desk, rooms, shared.channels, inbox, shared.n_viewers, wake
        )
        """The lesson that is on, if one is."""
        self._audience: Audience | None = None
        with self.readings.file_tab:
            if shared.presenting.stand is not None:
                self._audience = Audience(client, shared.presenting, shared.presenting.stand)
            FileTab(
                client,
                shared.session,
                ask,
                inbox.work,
                shared.take_experiment,
                shared.offer_preset,
                shared.save_dir,
            )
            self._share = Share(client, shared.session, shared.status_of, inbox.work, arrival)
            Export(client, shared.session, self._on_board, inbox.work)
            if shared.sessions is not None:
                Earlier(
                    client,
                    shared.session,
                    shared.submit,
                    inbox.work,
                    shared.n_viewers,
                    shared.sessions,
                )
        self.results = ResultsPanel(client, shared.calls, shared.service, ask, inbox, wake)
        clicked = Intent(self._clicked)
        client.scene.on_click()(clicked)
        client.scene.on_click(modifier="shift")(clicked)
        self._read_at = 0.0

    @property
    def number(self) -> int:
        """By which it is told from others."""
        return self.client.client_id

    @property
    def look(self) -> Look:
        """How this browser wants to see the board."""
        is_covered = self._hunts.is_watching or self.lesson.is_seen_closely
        return self.readings.view.look._replace(hunts=not is_covered)

    def _experiment(self, name: str) -> None:
        """Run an experiment, and show what comes of it."""
        begin = partial(run_shipped, self._shared.service, name)
        self._shared.inbox.work(self.client, begin, lambda _: self.results.open())

    def _on_board(self) -> OnBoard:
        snapshot = self._shared.status_of(self.client).snapshot
        return OnBoard(snapshot, self.look, self._extras, snapshot.generation)

    def seen(self, status: Status) -> Seen:
        """What it is to see of a board, given the status that is true for it."""
        look = self.look
        compares = look.layer == CHANGE.key and self.outlook.since is not None
        is_own = status.behind is not None or compares
        return Seen(look, self.client.client_id if is_own else None)

    def leave(self) -> None:
        """Answer no more calls of this browser."""
        self.outlook.leave()
        self.readings.leave()
        self._hunts.leave()
        self.time.leave()
        self.side.leave()
        self.lesson.leave()
        self.results.leave()

    def _clicked(self, client: viser.ClientHandle, event: viser.SceneClickEvent) -> None:
        if self.exhibit is None:
            return
        board, look = self.exhibit.board, self.exhibit.look
        if look.frame == ALL:
            heading = board.heading_under(event.ray_origin, event.ray_direction)
            if heading is not None:
                self.readings.view.choose_heading(heading)
                self._wake()
            return
        place = board.place_under(event.ray_origin, event.ray_direction)
        if place is None:
            return
        if self.octants.take_place(place, self._shared.status_of(self.client).snapshot, look):
            return
        size = self._shared.status_of(self.client).snapshot.world.size
        if self.lesson.take_cell(cell_under(place, size)):
            return
        shift = event.modifier == "shift"
        self._inspection.take_click(place, shift)
        if look.layer == REACH.key and not shift:
            self._go_to_rise(place, look)

    def _go_to_rise(self, place: tuple[float, float], look: Look) -> None:
        """Go to the moment at which value first came to a place of the board."""
        snapshot = self._shared.status_of(self.client).snapshot
        rise = rise_under(snapshot, look, place)
        if rise is None:
            return
        moments, inbox, line = self._shared.session.moments, self._shared.inbox, snapshot.generation
        moments.ask(
            lambda: moments.rise_of(line, rise.state, rise.trial),
            lambda found: inbox.put(partial(self.time.go_to, found)),
            partial(self.time.say, refused=True),
        )

    def frame(self, exhibit: Exhibit) -> bytes | None:
        """What this browser has not been sent yet of what it wants to see; None if nothing is."""
        former, sent, stage = self.exhibit, self._sent, exhibit.stage
        self.exhibit, self._sent = exhibit, stage.now
        if former is None or former is exhibit:
            return stage.frame_since(sent)
        return stage.frame_in_place_of(former.stage)

    def update(
        self, status: Status, texts: Texts, clock: str, every_s: float, now_s: float
    ) -> None:
        """Show a moment beside the board: what was asked for at once, the rest now and then."""
        snapshot, success = status.snapshot, texts.extras.success
        outcomes = None
        if success is not None and success.generation == snapshot.generation:
            outcomes = success.outcomes
        self._extras = texts.extras
        self.side.update(texts.look)
        self._hunts.update(status, texts.look, now_s)
        self._share.update(status)
        self._inspection.update(snapshot, texts.look, outcomes)
        self.octants.update(snapshot, texts.look)
        for root in self._drawn_alone:
            assign(root, "visible", texts.look.frame != ALL)
        self.results.update(now_s)
        if now_s - self._read_at >= every_s:
            self.readings.update(texts, clock)
            if self._audience is not None:
                self._audience.update()
            self._read_at = now_s
