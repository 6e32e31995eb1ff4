"""The weights by which a rule selects between skills, in the panel that steers."""

from collections.abc import Callable
from typing import Final

import viser

from app.live.snapshot import Snapshot
from app.page.number_field import DIALS_HTML, Dial, Limits
from app.page.widgets import Choice, assign
from app.server.callbacks import RefusedError
from app.words.plain import by_plain_name
from learners.parameters import WEIGHTS, value_of

_MOST: Final = 10.0
"""What differs more than that is as if the other skill were not there."""
_NO_SKILL: Final = "(no skill)"


class Weights:
    """A skill to choose, and its weight; not seen of a learner without a rule."""

    def __init__(
        self, gui: viser.GuiApi, ask: Callable[[viser.ClientHandle, str, float], object]
    ) -> None:
        """``ask`` is called with who has set which parameter to what."""
        self._ask = ask
        self._folder = gui.add_folder("Weights of skills", visible=False)
        with self._folder:
            self._skill: Choice[str | None] = Choice(
                gui,
                "Weight of",
                {},
                nothing=_NO_SKILL,
                hint="Whose weight is to be set; the rule multiplies what a skill expects by it.",
            )
            gui.add_html(DIALS_HTML)
            self._weight = Dial(
                gui,
                "Weight",
                1.0,
                Limits(0.0, _MOST, whole=False),
                0.1,
                "How much what this skill expects counts beside the others, from the next step on:"
                " at 0 not at all (learner.weights).",
                self._set,
            )

    def settle(self, now_s: float) -> None:
        """Ask for what came to rest."""
        self._weight.settle(now_s)

    def update(self, snapshot: Snapshot) -> None:
        """Show what is true."""
        learner = snapshot.spec.learner
        has_rule = learner.selection != "learned"
        assign(self._folder, "visible", has_rule)
        self._skill.offer(by_plain_name(learner.skills if has_rule else ()))
        if self._skill.chosen is not None:
            self._weight.show(value_of(snapshot.spec, f"{WEIGHTS}{self._skill.chosen}"))

    def _set(self, client: viser.ClientHandle, weight: float) -> None:
        if self._skill.chosen is None:
            raise RefusedError("there is no skill to be weighed; choose one")
        self._ask(client, f"{WEIGHTS}{self._skill.chosen}", weight)
