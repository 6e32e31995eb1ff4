"""The terms that people meet on the page, each in one plain sentence, and how they are marked.

A sentence may use other terms, but none that it could not be understood without.
"""

import json
from collections.abc import Mapping
from functools import lru_cache
from typing import Final

from markupsafe import Markup

from app.util.html import element

TERMS: Final[Mapping[str, str]] = {
    # The hunt
    "trial": "One hunt, from a new starting place until the prey is caught, flees, or time is up.",
    "step": "One move of the predator: to one of the eight cells around it, or staying.",
    "capture": "The predator reaches the prey unseen: the hunt is won, with a large reward.",
    "flight": "The prey sees the predator and flees: the hunt is lost, and costs something.",
    "time-out": "The hunt is cut off because it has taken too many steps; it earns nothing.",
    "reward": "What a hunt earns: much for a capture, less than nothing for being seen.",
    "success": "The share of the latest hunts that ended with a capture.",
    "visual field": "What the prey sees: the half-disc in front of it; whoever enters it is seen.",
    "heading": "The way the prey looks, one of eight; each hunt begins with another.",
    # What is learned
    "sensor ring": (
        "All places about as far from the prey: the predator senses which ring it is in, and not"
        " its exact distance."
    ),
    "direction": "On which side of the prey the predator is, as far as it can sense that.",
    "state": (
        "All that the predator senses of where it is: its ring, its direction, and which way the"
        " prey looks."
    ),
    "value": (
        "How good it is to be in a place: the reward that the predator expects from there on,"
        " less the longer it takes."
    ),
    "Q": (
        "What the predator expects to earn if it makes this choice now and goes on as well as it"
        " can."
    ),
    "steps to capture": (
        "Value in other words: a place is worth as much as a certain capture so many steps away."
    ),
    "option": "What can be chosen at each step: a skill, or a move where there are no skills.",
    "skill": "A way of moving that is learned for itself, such as going nearer or going round.",
    "selection": (
        "What chooses the skill for each step, and learns by trying which one pays in which place."
    ),
    "local reward": "What a skill is told of each move: whether it did what the skill is for.",
    "backup": "One bit of learning: the value of a place moves towards that of the next one.",
    "front": "The edge of the places that are worth something; it moves as value spreads.",
    "learning rate": "How far one experience moves a value (α): 0 not at all, 1 all the way.",
    "discount": "What is left of a value one step earlier (γ): at 0.9, each step costs a tenth.",
    # How it is taught
    "greedy": "Always taking what seems best, without any random moves.",
    "exploration": "Random choices now and then (with chance ε), so that other ways are tried.",
    "forced exploration": (
        "For some trials the learner is made to use one skill with a given chance, whether that"
        " pays or not, to find out what the skill is good for."
    ),
    "teaching": (
        "For some trials a script, which somebody wrote who knows the task, chooses the skill; the"
        " learner learns from what comes of it."
    ),
    "freeze": "What is frozen is used as it is, and learns nothing until it is let go.",
    "schedule": "The plan of which skill joins in which trial, and when it is explored.",
    "preset": "Ready-made settings to start from: the world, the skills and their schedule.",
    "run": "One learner from its first trial on.",
    "live": "The run as it is now, in which the learner goes on, whatever moment one looks at.",
    "the past": "A moment of a run before now, made again exactly; the live run goes on meanwhile.",
    "branch": (
        "Another way that a run might have gone: the same up to a moment, at which something was"
        " done otherwise."
    ),
    "seed": "The number that all chance in a run comes from: the same seed gives the same run.",
    "digest": "A fingerprint of what was learned: the same digest means exactly the same tables.",
    # Experiments
    "experiment": "Learners with many seeds each, so that what is chance can be told apart.",
    "variant": "One way of learning that an experiment compares with others.",
    "interval": (
        "Where the true mean is likely to lie, as far as so many runs can tell: 95 of 100 such"
        " ranges hold it."
    ),
    "paired difference": (
        "The difference of two variants seed by seed, so that the luck which both share drops out."
    ),
}
"""What each term means, by the term as it stands within a sentence."""


@lru_cache(maxsize=256)
def term(key: str, shown: str | None = None) -> Markup:
    """A term, which the page's script (``app/web/terms.js``) explains on hover, focus and touch.

    Args:
        key: one of ``TERMS``.
        shown: what stands there, if it is another form of the word.

    Raises:
        KeyError: there is no such term.
    """
    if key not in TERMS:
        raise KeyError(key)
    attributes = {"class_": "term", "role": "term", "tabindex": "0", "data-term": key}
    return element("span", shown or key, **attributes)


def table_html() -> Markup:
    """The glossary for the page's script; nothing is to be seen of it."""
    return element("div", "", **{"hidden": "", "data-terms": json.dumps(dict(TERMS))})
