"""The tour: five stops at the things that one needs first; the page's script leads through them."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from markupsafe import Markup

from app.util.html import element, joined
from app.words.glossary import term


class Stop(NamedTuple):
    """One thing of the page, and what there is to know of it."""

    at: str
    """Which it is, by the name that the script has for it (``app/web/tour.js``)."""
    title: str
    text: Sequence[Markup | str]
    """30 words at most."""


STOPS: Final = (
    Stop(
        "board",
        "The board",
        [
            "The prey is in the middle and looks right; the half-disc is what it sees. Colour says"
            " what each place is ",
            term("value", "worth"),
            ": the brighter, the nearer to a ",
            term("capture"),
            ".",
        ],
    ),
    Stop(
        "sentence",
        "What is going on",
        [
            "This says what the learner does right now, and the legend what the colours mean. ",
            "Words with dots under them, such as ",
            term("skill"),
            ", explain themselves.",
        ],
    ),
    Stop(
        "play",
        "Play, pause, speed",
        [
            "Space plays and pauses, J and K change the speed. At 200 ",
            term("step", "steps"),
            " a second you can watch single hunts.",
        ],
    ),
    Stop(
        "bar",
        "Time",
        [
            "Time runs to the right. The curve shows what hunts earn; the blocks show when skills"
            " join, are ",
            term("forced exploration", "explored"),
            " or ",
            term("freeze", "frozen"),
            ".",
        ],
    ),
    Stop(
        "skills",
        "Your turn",
        [
            "Add a skill by hand, early or late, and see what changes. Under Experiments the same"
            " is run with many ",
            term("seed", "seeds"),
            ".",
        ],
    ),
)

_COUNT: Final = "five stops"


def tour_html(times: int) -> str:
    """What the script needs: an offer below the sentence, and the stops.

    Args:
        times: how often the tour was asked for by a command; it begins when this grows.
    """
    stops = (
        element(
            "li",
            element("b", stop.title) + element("p", joined(stop.text, "")),
            **{"data-at": stop.at},
        )
        for stop in STOPS
    )
    offer = element(
        "aside",
        joined(
            [
                element("span", "New here?"),
                element("button", f"See {_COUNT}", type="button", **{"data-tour": "start"}),
                element("button", "No, thanks", type="button", **{"data-tour": "never"}),
            ],
            "",
        ),
        class_="offer",
        **{"aria-label": "A tour of the page"},
    )
    hidden = {"hidden": "", "data-times": f"{times}"}
    return str(offer + element("ol", joined(stops, ""), **hidden))
