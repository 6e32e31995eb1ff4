"""The board of one browser in a lesson: as the card wants it seen, marked, looked into, asked."""

import json
from typing import Any

from app.explain.chain import chain_html, chain_of
from app.lessons.spread import Spread
from app.lessons.story import (
    Guess,
    guessed_before,
    has,
    is_locked,
    question_of,
    run_value_of,
    shown,
    value_of,
)
from app.live.snapshot import Snapshot
from app.page.lesson.controls import FRAMES
from app.page.lesson.desk import Sitting
from app.page.lesson.done import opened_at
from app.page.lesson.hands import Hands
from app.page.lesson.marked import heading_known, place_in
from app.page.lesson.sitter import Sitter
from app.page.lesson.told import bar_asked, octants_asked
from app.picture.look import FOLDED, Look, heading_shown


class Dressing:
    """Of one browser. The render loop alone has to do with it."""

    def __init__(self, sitter: Sitter, hands: Hands) -> None:
        self._sitter, self._hands, self._rooms = sitter, hands, sitter.rooms
        self._dressed: tuple[str, int] | None = None
        """The lesson and the card as which the board was dressed last."""
        self._asked: tuple[Any, Any] = (None, None)
        """What the board and the bar are asked."""
        self._cell: tuple[int, int] | None = None
        """That is looked into."""
        self._of: object = None
        """Of which cell and moment it is said where the value comes from."""
        self._is_turned = False
        """Whether one heading is shown, since all of them as one would not show what is known."""
        self.inspected: str | None = None
        """Where the value of that cell comes from, as HTML; None if none is looked into."""

    def update(self, sitting: Sitting | None, snapshot: Snapshot, look: Look) -> None:
        """Dress the board for a card, or for none."""
        if sitting is None:
            self._undress()
            self._rooms.marked.show(None, snapshot, look)
            self._put_questions(None, None)
            return
        self._dress(sitting)
        card = sitting.card
        self._rooms.marked.show(None if card.look is None else card.look.mark, snapshot, look)
        heading = heading_shown(look, snapshot.heading)
        region, self._hands.region = self._hands.region, None
        if region is not None:
            if look.frame == FOLDED:
                heading = heading_known(region, snapshot)
                self._turn(heading)
            place = place_in(region, snapshot, heading)
            if place is not None:
                self._look_into(place, snapshot, heading)
        self._say_why(snapshot, heading)
        self._put_questions(*self._questions(sitting))

    def take_cell(self, cell: tuple[int, int] | None) -> bool:
        """Take a click on a cell of the board, if a lesson has to do with that.

        Args:
            cell: its column and row; None off the board.

        Returns:
            Whether nothing else is to come of it.
        """
        sitting, seen = self._sitter.taught, self._sitter.seen
        if sitting is None or seen is None:
            return False
        if has(shown(sitting.story, sitting.lesson.spec), "inspect") and cell is not None:
            heading = heading_shown(self._rooms.view.look, seen.snapshot.heading)
            self._look_into(cell, seen.snapshot, heading)
            self._sitter.wake()
        return True

    def _dress(self, sitting: Sitting) -> None:
        """Have the board be seen as the card wants it, once for each time that it is gone to."""
        key = (sitting.story.name, sitting.story.card)
        if key == self._dressed:
            return
        self._undress()
        self._dressed, card = key, sitting.card
        if card.look is not None:
            frame = None if card.look.frame is None else FRAMES[card.look.frame]
            self._rooms.view.show(card.look.layer, frame)
        if card.why is not None:
            self._hands.region = card.why.inspect

    def _undress(self) -> None:
        """Leave the card that was shown."""
        if self._dressed is None:
            return
        self._rooms.outlook.walk.go_live()
        self._rooms.inspection.look_into(None)
        if self._is_turned:
            self._is_turned = False
            self._rooms.view.show(None, FOLDED)
        self._dressed = self._cell = self._of = self.inspected = None
        self._hands.leave_card()

    # What is looked into

    def _turn(self, heading: int) -> None:
        """Show one heading alone, if another one than that of all as one is to be looked into."""
        if heading != 0:
            self._is_turned = True
            self._rooms.view.show(None, heading)

    def _look_into(self, cell: tuple[int, int], snapshot: Snapshot, heading: int) -> None:
        self._cell, self._of = cell, None
        self._rooms.inspection.look_into(cell)
        self._sitter.desk.doings.note_opened(opened_at(cell, snapshot, heading), snapshot.step)

    def _say_why(self, snapshot: Snapshot, heading: int) -> None:
        """Say where the value of a cell comes from, at a moment that stands still."""
        live = self._sitter.live
        key = (self._cell, snapshot.generation, snapshot.step, heading)
        if self._cell is None:
            self.inspected = None
        elif key != self._of and (self.inspected is None or not (live and live.playing)):
            self._of, self.inspected = key, chain_html(chain_of(snapshot, *self._cell, heading))

    # What is asked

    def _questions(self, sitting: Sitting) -> tuple[Any, Any]:
        """What the board and the bar are asked: the card's question, or what came of one. A curve
        or a moment that was guessed stays on the bar until something else is asked."""
        story, spec = sitting.story, sitting.lesson.spec
        told = self._sitter.shown(sitting)
        before = guessed_before(sitting.index, spec)
        if told is not None and told.is_ready:
            asked, question, given = told.asked, told.guess.card.id, value_of(told.given)
            locked, own, spread = True, told.own, told.spread
        else:
            found, name = spec.question_of(sitting.card), question_of(sitting.card)
            if found is None or name is None:
                return None, self._on_bar(sitting, before)
            asked, question, own, spread = found, name, None, Spread(())
            draft, locked = self._sitter.draft_of(sitting), is_locked(story, question)
            given = value_of(story.answers.get(question)) if draft is None else json.loads(draft)
        if asked.ask not in ("sectors", "moment", "sketch"):
            return None, self._on_bar(sitting, before)
        if asked.ask == "sectors":
            shares, of_class = None, self._sitter.of_class(sitting, question)["class"]
            if of_class is not None:
                counts = of_class["counts"].items()
                shares = {octant: count / of_class["n"] for octant, count in counts}
            return octants_asked(given, locked, own, spread, shares, story.language), None
        return None, bar_asked(asked, question, given, locked, own, spread, story.language)

    def _on_bar(self, sitting: Sitting, guess: Guess | None) -> Any:
        """A guess that stands on the bar, with what came of it as far as that is known."""
        if guess is None or guess.place == sitting.index or guess.card.question is None:
            return None
        given = sitting.story.answers.get(guess.card.id)
        if given is None or not given.locked:
            return None
        own = run_value_of(given)
        spread = Spread(()) if given.shown is None else self._sitter.desk.spread_of(sitting, guess)
        asked, language = guess.card.question, sitting.story.language
        return bar_asked(asked, guess.card.id, value_of(given), True, own, spread, language)

    def _put_questions(self, board: Any, bar: Any) -> None:
        if board != self._asked[0]:
            self._rooms.octants.ask(board, self._hands.chose_octants)
        if bar != self._asked[1]:
            self._rooms.time.ask(bar, self._hands.answered_on_bar)
        self._asked = (board, bar)
