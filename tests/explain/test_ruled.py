"""What is said of a cell where a rule selects, a choice is kept, or a command holds."""

import dataclasses
import functools

import numpy as np
import pytest
from markupsafe import Markup

from app.documents import presets
from app.explain.beside import cell_rows, repertoire
from app.explain.cell import reading_at
from app.explain.cell_html import reading_html
from app.explain.chain import action_text, chain_html, chain_of, ending_text, sum_text
from app.explain.ruled import ruling_in_words
from app.explain.sentence import said_of
from app.live import snapshot
from app.live.snapshot import HeldChoice, Snapshot
from app.picture.look import Look
from learners.comparators.feudal import Commanded
from learners.kernel import rows
from learners.run import Run
from sim.geometry import MOVES, N_MOVES

EAST, NORTH = (MOVES.tolist().index(way) for way in ([1, 0], [0, 1]))


@functools.cache
def fresh(preset: str, *settings: str) -> Snapshot:
    return snapshot.take(Run(presets.load(preset, settings), 1), preset, 0)


def told(moment: Snapshot, x: int, y: int, layer: str = "value", option: int = 0) -> str:
    """All that is read of a cell."""
    html = reading_html(reading_at(moment, x, y, 0), Look(layer=layer, option=option))
    return Markup(html).striptags()


def at_odds(rule: str) -> Snapshot:
    """Appetite wants to go east, which fear dreads; it wants north half as much."""
    run = Run(presets.load("static_appetite_fear", [f"learner.selection={rule}"]), 1)
    run.advance(max_steps=1)
    values = rows.values(run.state.skills)
    half = len(values) // 2
    values[:, :N_MOVES] = 0
    values[:half, EAST], values[:half, NORTH] = 2.0, 1.0
    values[half:, EAST] = -50.0
    rows.rescan_all(run.state.skills, run.state.skill_words)
    return snapshot.take(run, "static_appetite_fear", 0)


@pytest.mark.parametrize(
    ("rule", "said", "lead"),
    [
        (
            "collective",
            "the one that is worth most to all skills together: north. Appetite gives way, which"
            " costs 1 of its own reward.",
            "fear has its way against appetite",
        ),
        (
            "best_happiness",
            "that of the skill that expects most: east. Fear gives way, which costs 50 of its own"
            " reward.",
            "appetite has its way against fear",
        ),
    ],
)
def test_why_a_move_is_made_where_a_rule_selects(rule: str, said: str, lead: str) -> None:
    moment = at_odds(rule)
    reading = reading_at(moment, 40, 60, 0)
    assert reading.ruling is not None
    assert ruling_in_words(reading.ruling) == f"The move is {said}"
    text = told(moment, 40, 60, "chosen")
    assert text.startswith(f"Cell (40, 60): {lead}.")
    assert "The happiest skill expects 2 of its own reward." in text
    assert "steps from a capture" not in text
    assert {wish.name for wish in reading.ruling.wishes} == {"appetite", "fear"}


def test_what_a_skill_gives_up_is_said_of_the_one_that_is_shown() -> None:
    moment = at_odds("collective")
    assert "the move costs appetite 1." in told(moment, 40, 60, "stake", 0)
    assert "the move costs fear nothing." in told(moment, 40, 60, "stake", 1)


def test_w_is_told_where_it_is_learned() -> None:
    moment = at_odds("w_learning")
    reading = reading_at(moment, 40, 60, 0)
    assert reading.ruling is not None
    assert all(wish.w is not None for wish in reading.ruling.wishes)
    assert "W of fear is" in told(moment, 40, 60, "stake", 1)


def test_no_chain_leads_to_a_capture_where_a_rule_selects() -> None:
    chain = chain_of(at_odds("collective"), 40, 60, 0)
    assert not chain.links
    assert chain.ending == "rule"
    assert "own reward" in ending_text(chain)
    assert "No chain leads" in Markup(chain_html(chain)).striptags()


def test_the_sentence_says_how_a_learner_chooses() -> None:
    said = {
        preset: said_of(fresh(preset)).striptags()
        for preset in ("static_appetite_fear", "feudal", "q_lambda", "standard_q_held")
    }
    assert "No table selects: each move is the one" in said["static_appetite_fear"]
    assert "No skill has learned anything yet." in said["static_appetite_fear"]
    assert "A command holds until the predator leaves the region." in said["feudal"]
    assert "Each reward reaches the moves that led to it." in said["q_lambda"]
    assert "A choice is kept until the place changes, 10 steps at most." in said["standard_q_held"]
    persistent = said_of(fresh("hierarchical_3_persistent")).striptags()
    assert "A choice is kept for 4 steps." in persistent
    agreed = said_of(at_odds("collective")).striptags()
    assert "They agree in 0% of places; elsewhere fear has its way." in agreed


def test_learners_beside_each_other_say_what_is_special() -> None:
    def of(preset: str) -> str:
        return repertoire(fresh(preset).spec)

    assert of("static_appetite_fear").endswith(", selected by a rule")
    assert of("standard_q_held").endswith(", a choice is kept until the place changes")
    assert of("hierarchical_3_persistent").endswith(", a choice is kept 4 steps")
    assert of("hierarchical_3_taught").endswith(", taught for 300 trials")
    readings = [reading_at(at_odds("collective"), 40, 60, 0), None]
    worth = cell_rows(readings)[0]
    assert worth.values == ("2 to a skill", "not on this board")


# What is kept -------------------------------------------------------------------------------


def worth_towards_the_prey(preset: str) -> Snapshot:
    """A moment in which going east is worth something, the more the nearer the prey."""
    base = fresh(preset)
    value = np.zeros_like(base.selection_q)
    worth = np.array([95.0 - 5.0 * ring for ring in range(value.shape[1])], np.float32)
    value[..., EAST] = worth[None, :, None]
    return dataclasses.replace(base, selection_q=value, value=value.max(axis=-1))


def test_a_link_of_a_kept_choice_is_all_of_its_steps() -> None:
    moment = worth_towards_the_prey("standard_q_held")
    chain = chain_of(moment, 30, 60, 0)
    assert chain.ending == "capture"
    n_links = len(chain.links)
    assert n_links < 30
    first = chain.links[0]
    assert first.steps == first.power > 1
    assert action_text(first) == f"move east for {first.steps} steps"
    assert first.target == pytest.approx(0.9**first.power * first.future)
    assert f"0.9{'⁰¹²³⁴⁵⁶⁷⁸⁹'[first.power]} ×" in sum_text(first)
    # Each cell on the way is there, so that it can be drawn.
    assert len(chain.cells) == sum(link.steps for link in chain.links) + 1 == 31
    last = chain.links[-1]
    assert last.reward == pytest.approx(100 * 0.9 ** (last.steps - 1))
    assert "once for each of its steps" in Markup(chain_html(chain)).striptags()


def test_a_chain_with_traces_says_that_earlier_moves_learn_as_well() -> None:
    chain = chain_of(worth_towards_the_prey("q_lambda"), 50, 60, 0)
    assert chain.trace == pytest.approx(0.45)
    assert len(chain.links) == 10
    assert "by 0.45 of it one move earlier, 0.2 two" in Markup(chain_html(chain)).striptags()


def test_how_long_a_choice_holds_is_said_of_its_place() -> None:
    base = fresh("standard_q_held")
    reading = reading_at(base, 40, 60, base.heading)
    state = (base.heading * 18 + reading.ring) * 24 + reading.direction
    moment = dataclasses.replace(base, held=HeldChoice(EAST, state, 3))
    here, there = reading_at(moment, 40, 60, base.heading), reading_at(moment, 90, 60, base.heading)
    kept = "A choice that is made here is kept until the place changes, 10 steps at most."
    assert there.holding == kept
    assert here.holding == f"{kept} Now moving east is kept, for 7 steps more at most."
    assert reading_at(fresh("timed"), 40, 60, 0).holding == ""


def test_the_region_and_the_command_that_holds_are_said() -> None:
    base = fresh("feudal")
    reading = reading_at(base, 40, 60, base.heading)
    region = reading.ring // 3 * 8 + reading.direction // 3
    moment = dataclasses.replace(base, commanded=Commanded(2, region, 12))
    holding = reading_at(moment, 40, 60, base.heading).holding
    first = reading.ring // 3 * 3 + 1
    assert f"all of rings {first} to {first + 2}" in holding
    assert holding.endswith("Now inwards holds here, for 38 steps more at most.")
