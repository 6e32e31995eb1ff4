"""Findings on chapter 3 and on what chapter 4 says of the problem, the skills and the timing."""

from collections.abc import Sequence

from app.experiments import facts
from app.experiments.facts import PRACTICE_STEPS, SOON_TRIALS
from app.results.findings import (
    CLOSE,
    FINAL,
    MUCH_MORE,
    REACHED,
    STATES_A_TRIAL,
    STEPS,
    Finding,
    ahead,
    named,
    share_of,
    term,
)
from app.results.thesis.quantities import AT_HORIZON, EARLY_LENGTH

_TIMED = ("120", "timed")

# --- Chapter 3: the parts of timed learning ------------------------------------------------------

_PARTS = "Parts of timed learning"
_FREEZE = (
    "To hold the selection still while a skill is learned may be very beneficial, since what is"
    " learned too early is hard to overcome."
)
_ONE_AT_A_TIME = (
    "Where some reward can be had with few skills, to bring them in one at a time may be of"
    " advantage over starting with all of them."
)
_MOTIVATE = (
    "Random exploration may not do to take a new skill in; to try it vigorously for a while might"
    " speed learning up significantly."
)
_SAFE = (
    "A new skill comes in without changing the utility of any state, which is extremely valuable"
    " to learning."
)

_OF_PARTS: Sequence[Finding] = (
    ahead(
        _PARTS,
        "3.3.1",
        _FREEZE,
        "timed ends significantly above timed without a freeze",
        term(*_TIMED),
        term("120", "timed, no freeze"),
        MUCH_MORE,
    ),
    ahead(
        _PARTS,
        "3.3.2",
        _ONE_AT_A_TIME,
        "timed ends above timed with all skills from the start, explored when timed does so",
        term(*_TIMED),
        term("120", "timed, no timers"),
    ),
    ahead(
        _PARTS,
        "3.3.2",
        _ONE_AT_A_TIME,
        "timed ends above timed whose circle and avoid come in together, but are explored in turn",
        term(*_TIMED),
        term("120", "timed, joined together"),
    ),
    ahead(
        _PARTS,
        "3.3.2",
        _ONE_AT_A_TIME,
        "timed ends above timed with all skills introduced and explored at the start",
        term(*_TIMED),
        term("120", "timed, all at once"),
    ),
    ahead(
        _PARTS,
        "3.3.3",
        _MOTIVATE,
        "timed learns significantly faster than timed without explorations: from 1.5 to 2 M steps",
        term(*_TIMED, "1.5–2 M"),
        term("120", "timed, no episodes", "1.5–2 M"),
        MUCH_MORE,
    ),
    ahead(
        _PARTS,
        "3.3.4",
        _SAFE,
        "timed ends significantly above timed whose new skills start at the initial value"
        " everywhere",
        term(*_TIMED),
        term("120", "timed, unsafe"),
        MUCH_MORE,
    ),
)

# --- Sections 4.1 and 4.2: the problem and the skills --------------------------------------------

_PROBLEM = ("The problem", "4.1.3")
_SPARSE = "Reward is sparse: the predator may go for hundreds of steps without any."
_SLOW = "In many of the experiments it took some 3 M steps to converge."
_SKILLS = ("Skills", "4.2.2")
_SOON = "Skills can be learned quickly, and often do well within 50,000 steps."

_NOISE = "The selection learns at a low rate, since the skills that it learns about are noisy."

_SOON_STEPS, _ = PRACTICE_STEPS

_OF_PROBLEM: Sequence[Finding] = (
    Finding(
        *_PROBLEM,
        _SPARSE,
        "an early trial of standard Q lasts for more than 200 steps on average",
        (term("120", "standard_q", EARLY_LENGTH),),
        named("above", 200, STEPS),
    ),
    ahead(
        *_PROBLEM,
        _SLOW,
        "standard Q gets much better still after 2 M steps: it ends above its 1.5 to 2 M steps",
        term("120", "standard_q"),
        term("120", "standard_q", "1.5–2 M"),
        MUCH_MORE,
    ),
    ahead(
        *_PROBLEM,
        _SLOW,
        "standard Q hardly changes after 4 M steps: it ends close to its 3.5 to 4 M steps",
        term("120", "standard_q"),
        term("120", "standard_q", "3.5–4 M"),
        CLOSE,
    ),
    *(
        Finding(
            *_SKILLS,
            _SOON,
            f"after {_SOON_STEPS:,} steps {name} makes progress in more than 0.75 of its steps",
            (term("120", learner, facts.progress(skill, _SOON_STEPS)),),
            named("above", 0.75, share_of("steps")),
        )
        for name, learner, skill in (
            ("approach, learned alone,", "timed", "approach"),
            ("approach, learned together with circle,", "hierarchical_2", "approach"),
            ("circle, learned together with approach,", "hierarchical_2", "circle_clockwise"),
        )
    ),
    ahead(
        *_SKILLS,
        _NOISE,
        "two skills end above two skills whose selection learns at the rate of the skills, 0.6",
        term("120", "hierarchical_2"),
        term("120", "hierarchical_2, alpha 0.6"),
    ),
)

# --- Section 4.3.3: the choice of the timing -----------------------------------------------------

_TIMING = ("Timing", "4.3.3")
_STATE_A_TRIAL = (
    "With approach alone value spreads to one new state a trial at the most, so that it takes some"
    " 4,000 trials to get to every state that can be reached."
)
_ROBUST = (
    "As one timing served in all worlds, timed learning seems fairly robust to its timing, which"
    " was not tested."
)

TIMING_FINDINGS: Sequence[Finding] = (
    Finding(
        *_TIMING,
        _STATE_A_TRIAL,
        "with approach alone, value gets to less than 1 new state a trial",
        (term(*_TIMED, facts.VALUED_A_TRIAL),),
        named("below", 1, STATES_A_TRIAL),
    ),
    Finding(
        *_TIMING,
        _STATE_A_TRIAL,
        f"after {SOON_TRIALS:,} trials value has reached most of the states that it has when circle"
        " comes in",
        (term(*_TIMED, facts.VALUED_EARLY),),
        REACHED,
    ),
    *(
        ahead(
            *_TIMING,
            _ROBUST,
            f"it hardly matters {when} whether skills join at {trials}",
            term(*_TIMED, quantity),
            term("120", learner, quantity),
            CLOSE,
        )
        for learner, trials in (
            ("timed, early", "1,500 and 3,000 or when the thesis has it"),
            ("timed, late", "18,000 and 24,000 or when the thesis has it"),
        )
        for when, quantity in (("in the end", FINAL), ("at 5.5 M steps", AT_HORIZON))
    ),
    # Its end is above, where skills that join at once are what is tested.
    ahead(
        *_TIMING,
        _ROBUST,
        "it hardly matters at 5.5 M steps whether skills join at the start or when the thesis has"
        " it",
        term(*_TIMED, AT_HORIZON),
        term("120", "timed, all at once", AT_HORIZON),
        CLOSE,
    ),
)
"""Of the end of section 4.3.3."""

FINDINGS: Sequence[Finding] = (*_OF_PARTS, *_OF_PROBLEM)
"""Of chapter 3 and sections 4.1 and 4.2."""
