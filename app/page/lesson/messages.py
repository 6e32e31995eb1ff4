"""What the frame of a lesson sends: one struct a message, with bounds.

Whatever fits none of these comes from no hand on our page, and is dropped by whoever decodes
:data:`FromLesson`. Whether an answer, a card or a control is one that the lesson has is judged by
the panel that takes it.
"""

from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from app.live.story import MOST_CARDS

MOST_PARTS: Final = 64
"""Of a lesson's file that is sent."""
MOST_OF_PART: Final = 1_500
"""Characters of one of them: with all that JSON adds it is one message."""

Name = Annotated[str, Meta(min_length=1, max_length=200)]
"""Of a lesson, a question, a control."""
Language = Annotated[str, Meta(min_length=2, max_length=8)]


class _Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do"):
    """Something that a hand did; tagged by what is to be done."""


# --- Which lesson --------------------------------------------------------------------------------


class Start(_Message, frozen=True, tag="start"):
    """Take a lesson where it was left, or ``again`` from its beginning."""

    name: Name
    language: Language | None = None
    again: bool = False


class Leave(_Message, frozen=True, tag="leave"):
    """Have no lesson be on, in all browsers."""


class Free(_Message, frozen=True, tag="free"):
    """Open everything, in this browser."""


class BackToLesson(_Message, frozen=True, tag="back_to_lesson"):
    """See the lesson's card again, in this browser, and its run if another is on the board."""


class SetLanguage(_Message, frozen=True, tag="language"):
    """Read it in another language."""

    language: Language


class Upload(_Message, frozen=True, tag="upload"):
    """A part of a lesson's file, in their order."""

    name: Name
    part: Annotated[int, Meta(ge=0, lt=MOST_PARTS)]
    parts: Annotated[int, Meta(ge=1, le=MOST_PARTS)]
    text: Annotated[str, Meta(max_length=MOST_OF_PART)]


# --- Which card ----------------------------------------------------------------------------------


class Next(_Message, frozen=True, tag="next"):
    """Go on to the next card."""


class Back(_Message, frozen=True, tag="back"):
    """Go back to the card before."""


class Go(_Message, frozen=True, tag="go"):
    """Go to a card that was shown already."""

    card: Annotated[int, Meta(ge=0, lt=MOST_CARDS)]


# --- What is done on it --------------------------------------------------------------------------


class Answer(_Message, frozen=True, tag="answer"):
    """Answer a question; until it is committed, another answer takes its place."""

    id: Name
    value: Any


class Commit(_Message, frozen=True, tag="commit"):
    """Let the answer stand."""

    id: Name
    confidence: Literal[50, 70, 90] | None = None


class Hint(_Message, frozen=True, tag="hint"):
    """Say a little more; the last hint does what is to be done."""


class Rewind(_Message, frozen=True, tag="rewind"):
    """Go back to before, where what the card asks for can no longer come true."""


class Use(_Message, frozen=True, tag="use"):
    """Use one of the controls that the lesson shows."""

    control: Name
    value: bool | float | Annotated[str, Meta(max_length=200)] | None = None


# --- A class -------------------------------------------------------------------------------------


class AskClass(_Message, frozen=True, tag="ask_class"):
    """Ask the class the question of this card."""


class VoteAgain(_Message, frozen=True, tag="vote_again"):
    """Ask it once more, the first answers being hidden."""


class RevealClass(_Message, frozen=True, tag="reveal_class"):
    """Show what it answered, with what the run did."""


class EndClass(_Message, frozen=True, tag="end_class"):
    """Ask it nothing any more, and forget what it answered."""


OfClass = AskClass | VoteAgain | RevealClass | EndClass
FromLesson = (
    Start
    | Leave
    | Free
    | BackToLesson
    | SetLanguage
    | Upload
    | Next
    | Back
    | Go
    | Answer
    | Commit
    | Hint
    | Rewind
    | Use
    | AskClass
    | VoteAgain
    | RevealClass
    | EndClass
)
"""All of them."""
