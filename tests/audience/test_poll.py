"""What a class is asked, and what comes of its answers: never whose they are, and never of few."""

import threading

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.audience.poll import FEWEST, NOTHING_ASKED, Poll, answer_to, counts_of
from app.audience.seats import SHAPES, Seat
from app.audience.wishes import Value
from app.picture.octants import OCTANTS
from app.player.classroom import Question

WHICH = Question("spread", "choice", "Which?", (("a", "A"), ("b", "<b>B</b>"), ("c", "C")))
WHERE = Question("where", "sectors", "Where?", tuple((name, name) for name in OCTANTS))
HOW_MANY = Question("many", "number", "How many?", low=-1, high=100, unit="places")
WHEN = Question("when", "moment", "When?", low=0, high=40_000)
OUTCOME = {"run": "a", "twenty": {"n": 20, "counts": {"a": 20}}}


def seats(n: int) -> list[Seat]:
    return [Seat(number) for number in range(1, n + 1)]


def poll_of(question: Question = WHICH) -> Poll:
    poll = Poll(lambda: None)
    poll.ask(question)
    return poll


def ballot_of(poll: Poll) -> int:
    return poll.sent()["ask"]["ballot"]


def answered(poll: Poll, who: list[Seat], *values: Value) -> None:
    for seat, value in zip(who, values, strict=True):
        assert poll.answer(seat, ballot_of(poll), value)


def test_the_newest_answer_of_a_seat_counts_until_it_is_revealed() -> None:
    poll, who = poll_of(), seats(5)
    answered(poll, who, *"abcab")
    answered(poll, who[:1], "b")
    assert poll.answer_of(who[0]) == "b"
    assert poll.state("spread", True, who)["answered"] == 5
    ballot = ballot_of(poll)
    poll.reveal()
    poll.come_out("spread", OUTCOME)
    assert not poll.answer(who[1], ballot, "a")
    assert poll.sent()["reveal"]["class"] == {"n": 5, "counts": {"a": 1, "b": 3, "c": 1}}


def test_nothing_is_shown_before_it_is_revealed() -> None:
    poll, who = poll_of(), seats(9)
    answered(poll, who, *"aaaaaaabc")
    state = poll.state("spread", True, who)
    assert (state["class"], state["before"], state["answered"], state["seats"]) == (
        None,
        None,
        9,
        9,
    )
    assert state["can"] == ["again", "reveal", "end"]
    assert poll.sent()["reveal"] is None


def test_a_seat_that_was_given_to_somebody_else_counts_no_more() -> None:
    poll, who = poll_of(), seats(6)
    answered(poll, who[:5], *"aaaab")
    # As :meth:`Seats.sit` has it, for who comes when all seats are taken.
    who[4].clear()
    answered(poll, who[5:], "c")
    poll.reveal()
    assert poll.sent()["reveal"]["class"] == {"n": 5, "counts": {"a": 4, "b": 0, "c": 1}}


@pytest.mark.parametrize("n", [0, 1, FEWEST - 1])
def test_of_fewer_than_five_nothing_is_ever_shown(n: int) -> None:
    poll, who = poll_of(), seats(n)
    answered(poll, who, *"aaaaaaa"[:n])
    poll.reveal()
    poll.come_out("spread", OUTCOME)
    reveal = poll.sent()["reveal"]
    assert (reveal["class"], reveal["few"], reveal["run"]) == (None, True, OUTCOME["run"])
    assert poll.state("spread", True, who)["class"] is None


def test_the_first_answers_are_hidden_until_the_second_are_shown_too() -> None:
    poll, who = poll_of(), seats(6)
    answered(poll, who, *"aaaabc")
    poll.vote_again()
    assert poll.answer_of(who[0]) is None
    state = poll.state("spread", True, who)
    assert (state["round"], state["hidden"], state["answered"], state["class"]) == (
        2,
        True,
        0,
        None,
    )
    assert poll.sent()["reveal"] is None
    answered(poll, who, *"bbbbbb")
    # There is no third time.
    poll.vote_again()
    assert poll.state("spread", True, who)["round"] == 2
    poll.reveal()
    reveal = poll.sent()["reveal"]
    assert reveal["before"]["counts"] == {"a": 4, "b": 1, "c": 1}
    assert reveal["class"]["counts"] == {"a": 0, "b": 6, "c": 0}


def test_either_ballot_has_to_have_five() -> None:
    poll, who = poll_of(), seats(6)
    answered(poll, who, *"aaaabc")
    poll.vote_again()
    answered(poll, who[:2], *"bb")
    poll.reveal()
    reveal = poll.sent()["reveal"]
    assert (reveal["class"], reveal["few"], reveal["before"]["n"]) == (None, True, 6)


def test_an_answer_that_comes_late_is_for_nothing() -> None:
    poll, who = poll_of(), seats(1)
    first = ballot_of(poll)
    poll.vote_again()
    assert not poll.answer(who[0], first, "a")
    poll.ask(HOW_MANY)
    assert not poll.answer(who[0], first, 7)
    assert poll.answer(who[0], ballot_of(poll), 7)
    poll.end()
    assert not poll.answer(who[0], first + 2, 7)


def test_another_question_forgets_the_former() -> None:
    poll, who = poll_of(), seats(6)
    answered(poll, who, *"aaaaaa")
    poll.ask(WHERE)
    assert poll.state("where", True, who)["answered"] == 0
    poll.reveal()
    assert poll.sent()["reveal"]["class"] is None


def test_whoever_goes_on_to_another_card_takes_no_more_answers() -> None:
    poll, who = poll_of(), seats(6)
    poll.show("spread")
    answered(poll, who, *"aaaaaa")
    poll.show("add")
    assert not poll.answer(who[0], 1, "b")
    assert poll.sent() == NOTHING_ASKED
    # What was answered waits for what comes of it, and is revealed on the card that tells it.
    state = poll.state("add", False, who)
    assert (state["answered"], state["asking"], state["can"]) == (6, False, ["reveal", "end"])
    poll.show("see_spread")
    poll.reveal()
    poll.come_out("other", {**OUTCOME, "run": "c"})
    poll.come_out("spread", OUTCOME)
    assert poll.sent()["ask"]["id"] == "spread"
    assert poll.sent()["reveal"]["run"] == "a"
    assert poll.found("spread")["class"] == {"n": 6, "counts": {"a": 6, "b": 0, "c": 0}}
    assert poll.found("see_spread")["class"] is None
    poll.show("why_back")
    assert poll.sent() == NOTHING_ASKED
    state = poll.state("why_back", True, who)
    assert (state["class"], state["answered"], state["can"]) == (None, 0, ["ask", "end"])


def test_after_going_back_one_can_vote_again_and_not_go_on_answering() -> None:
    poll, who = poll_of(), seats(6)
    poll.show("spread")
    answered(poll, who, *"aaaaaa")
    poll.show("add")
    poll.show(None)
    poll.show("spread")
    assert not poll.answer(who[0], 1, "b")
    assert poll.state("spread", True, who)["can"] == ["ask", "again", "reveal", "end"]
    poll.vote_again()
    answered(poll, who, *"bbbbbb")
    assert poll.state("spread", True, who)["can"] == ["reveal", "end"]


def test_when_it_ends_nothing_is_left() -> None:
    poll, who = poll_of(), seats(6)
    answered(poll, who, *"aaaaaa")
    poll.vote_again()
    answered(poll, who, *"bbbbbb")
    poll.reveal()
    poll.come_out("spread", OUTCOME)
    poll.end()
    assert poll.sent() == {"ask": None, "reveal": None}
    kept = {name: value for name, value in vars(poll).items() if value}
    # How many ballots there have been, so that a late answer meets none.
    assert kept.keys() - {"_changed", "_lock"} == {"_n_ballots"}
    poll.reveal()
    poll.come_out("spread", OUTCOME)
    poll.vote_again()
    assert poll.sent() == {"ask": None, "reveal": None}


def test_whoever_is_forgotten_does_not_answer() -> None:
    poll, (seat,) = poll_of(), seats(1)
    seat.is_taken = False
    assert not poll.answer(seat, ballot_of(poll), "a")


@pytest.mark.parametrize(
    ("question", "value", "counted"),
    [
        (WHICH, "b", "b"),
        (WHICH, "A", None),
        (WHICH, "<b>B</b>", None),
        (WHICH, 1, None),
        (WHICH, ("a",), None),
        (WHERE, ("n", "e"), ("e", "n")),
        (WHERE, ("n", "n"), ("n",)),
        (WHERE, (), None),
        (WHERE, ("x",), None),
        (WHERE, "n", None),
        (HOW_MANY, 7, 7),
        (HOW_MANY, -1, -1),
        (HOW_MANY, 2.5, 2.5),
        (HOW_MANY, 100.5, None),
        (HOW_MANY, -2, None),
        (HOW_MANY, "7", None),
        (WHEN, 2_400.4, 2_400),
        (WHEN, -1, None),
        (WHEN, 50_000, None),
    ],
)
def test_only_what_answers_the_question_is_an_answer(
    question: Question, value: Value, counted: Value | None
) -> None:
    assert answer_to(question, value) == counted


def test_octants_are_counted_each() -> None:
    who = seats(5)
    answers: dict[Seat, Value] = dict(
        zip(who, [("e",), ("e", "n"), ("n",), ("w",), ("e",)], strict=True)
    )
    found = counts_of(WHERE, answers)
    assert found is not None
    assert found["n"] == 5
    assert {name: n for name, n in found["counts"].items() if n} == {"e": 3, "n": 2, "w": 1}


@given(st.permutations([1, 5, 5, 70, 99]))
def test_numbers_do_not_tell_who_gave_them(values: list[int]) -> None:
    found = counts_of(HOW_MANY, dict(zip(seats(5), values, strict=True)))
    assert found == {"n": 5, "values": [1, 5, 5, 70, 99]}


def test_what_is_sent_to_all_says_nothing_of_seats() -> None:
    poll, who = poll_of(), seats(6)
    answered(poll, who, *"abcabc")
    poll.reveal()
    text = msgspec.json.encode(poll.sent()).decode()
    assert not any(shape in text for shape in ("shape", "seat", *SHAPES))


def test_answers_of_many_threads_are_each_counted() -> None:
    poll, who = poll_of(), seats(60)
    ballot = ballot_of(poll)

    def answer(mine: list[Seat]) -> None:
        for n in range(30):
            for seat in mine:
                assert poll.answer(seat, ballot, "abc"[n % 3])

    parts = (who[:20], who[20:40], who[40:])
    threads = [threading.Thread(target=answer, args=(mine,)) for mine in parts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    poll.reveal()
    assert poll.sent()["reveal"]["class"] == {"n": 60, "counts": {"a": 0, "b": 0, "c": 60}}


def test_octants_can_be_taken_back() -> None:
    poll, (seat,) = poll_of(WHERE), seats(1)
    answered(poll, [seat], ("n",))
    assert poll.answer(seat, ballot_of(poll), ())
    assert poll.answer_of(seat) is None
    assert not poll.answer(seat, ballot_of(poll), ())


def test_the_same_outcome_is_told_once() -> None:
    told: list[int] = []
    poll = Poll(lambda: told.append(1))
    poll.ask(WHICH)
    poll.come_out("spread", OUTCOME)
    poll.reveal()
    assert len(told) == 2
    for outcome in (OUTCOME, dict(OUTCOME)):
        poll.come_out("spread", outcome)
    assert len(told) == 3
    assert poll.sent()["reveal"]["run"] == OUTCOME["run"]
