"""Starting again, with which preset, seed and schedule; and the way back to what was before."""

from collections.abc import Mapping
from typing import Final

import viser

from app.live.requests import GoBack, StartAgain
from app.live.status import Status
from app.page.inbox import Ask, Intent, StatusOf
from app.page.number_field import Limits, NumberField
from app.page.widgets import CALM, DESTROYS, Choice, Input, add_hints, assign
from app.schedule.carried import drawn_schedule
from learners.spec import RunSpec
from sim.rng import MAX_SEED

MOST_LOADED: Final = 16
"""Presets besides the shipped ones that the list keeps; of more, those used least lately go."""


class StartingAgain:
    """The folder, in the container that is current; shared by all browsers."""

    def __init__(
        self,
        gui: viser.GuiApi,
        presets: Mapping[str, RunSpec],
        ask: Ask,
        status_of: StatusOf,
        status: Status,
    ) -> None:
        self._status_of = status_of
        self._presets = dict(presets)
        self._loaded: dict[str, RunSpec] = {}
        """Presets besides those, the latest last."""
        self._shown: int | None = None
        """Generation of the run whose preset and seed are offered to be started again."""
        snapshot = status.snapshot
        with gui.add_folder("Start again"):
            self._note(snapshot.preset, snapshot.preset_spec)
            self._preset: Choice[str] = Choice(
                gui,
                "Preset",
                self._offered(),
                hint="The world, the learner and the schedule that the next run begins with.",
            )
            self._preset.choose(snapshot.preset)
            self._seed = NumberField(
                gui,
                "Seed",
                snapshot.seed,
                Limits(0, MAX_SEED, grouped=False),
                "All chance in a run comes from this whole number: the same one gives the same run"
                " again.",
            )
            self._keeps = Input(
                gui.add_checkbox(
                    "Keep the drawn schedule",
                    True,
                    visible=False,
                    hint="The next run has the schedule as it was changed in this one. Without this"
                    " it has the preset's own.",
                ),
                lambda _, __: None,
            )
            again = gui.add_button(
                "Start again",
                icon=viser.Icon.REFRESH,
                color=DESTROYS,
                hint="Another run from its first trial, which goes on if this one does. This run is"
                " set aside, and can be taken up again.",
            )
            self._back = gui.add_button(
                "Back",
                icon=viser.Icon.ARROW_BACK_UP,
                color=CALM,
                visible=False,
                hint="Take up the run again that was set aside, where it was. One is kept, the"
                " latest.",
            )
            add_hints(gui, again, self._back)
        again.on_click(Intent(lambda client, _: ask(client, self._request(client))))
        self._back.on_click(Intent(lambda client, _: ask(client, GoBack())))

    @property
    def presets(self) -> Mapping[str, RunSpec]:
        """All that are in the list, by name."""
        return {**self._presets, **self._loaded}

    def offer(self, name: str, spec: RunSpec) -> None:
        """Have a preset in the list that somebody saved or loaded."""
        self._note(name, spec)
        self._preset.offer(self._offered())

    def update(self, status: Status) -> None:
        """Show what is true."""
        snapshot = status.snapshot
        # A branch is of the same preset and seed: what was set here stays.
        if self._shown != snapshot.generation and status.behind is None:
            self._shown = snapshot.generation
            self._note(snapshot.preset, snapshot.preset_spec)
            self._preset.offer(self._offered())
            self._preset.choose(snapshot.preset)
            self._seed.put(snapshot.seed)
            self._keeps.put(True)
        is_same = self._preset.chosen == snapshot.preset
        assign(self._keeps.handle, "visible", is_same and drawn_schedule(snapshot) is not None)
        assign(self._back, "visible", status.aside is not None)
        assign(self._back, "label", f"Back to {status.aside}")

    def _request(self, client: viser.ClientHandle) -> StartAgain:
        snapshot, preset = self._status_of(client).snapshot, self._preset.chosen
        spec = self._presets.get(preset) or self._loaded[preset]
        keeps = preset == snapshot.preset and bool(self._keeps.handle.value)
        schedule = drawn_schedule(snapshot) if keeps else None
        return StartAgain(spec, preset, int(self._seed.read()), schedule)

    def _offered(self) -> dict[str, str]:
        return {name: name for name in (*self._presets, *self._loaded)}

    def _note(self, name: str, spec: RunSpec) -> None:
        """Let the preset of a run be started again."""
        if name in self._presets:
            self._presets[name] = spec
            return
        self._loaded.pop(name, None)
        self._loaded[name] = spec
        while len(self._loaded) > MOST_LOADED:
            del self._loaded[next(iter(self._loaded))]
