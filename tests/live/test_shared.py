"""Sessions from elsewhere: what is shared is read as it was, and what means ill does no harm."""

import base64
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import pytest

from app.explain.branches import name_of
from app.explain.opened import contents_in_words, verdict_in_words
from app.live import shared
from app.live.made_again import made_again
from app.live.past import Budget
from app.live.places import Place
from app.live.records import Began, Branched, Gave, Marked, NamedLine, Record, Stood, Unmarked
from app.live.replayed import ReplayError, replayed
from app.live.requests import AddMark, Branch, MakeLive, NameLine, Request, TrialOnce
from app.live.session import Session
from app.live.shared import (
    MOST_BYTES,
    MOST_CHARACTERS,
    code_of,
    contents_of,
    is_code,
    read_file,
    read_link,
    read_shared,
)
from app.live.story import LongText, TookLesson
from app.live.worker import FULL_SPEED
from app.live.written import (
    SessionError,
    Written,
    read,
    read_data,
    whole,
    with_sums,
    without_sums,
)
from learners.commands import (
    Command,
    Explore,
    FreezeSelection,
    FreezeSkills,
    SetParameter,
    SetSchedule,
    Undo,
)
from learners.run import Run
from learners.schedule_spec import EpisodeSpec
from tests.support.hostile import mutation, packed
from tests.support.journals import HEADER
from tests.support.lines import SEED, SPEC
from tests.support.memory import peak_of
from tests.support.sessions import settle

MUTATIONS = 300
PARTS = 5
MOST_STEPS = 400_000
"""That may be made of a mutation here."""
Made = TypeVar("Made")
NAME = Path("theirs.pounce")
BEGAN = Began(0, "timed", SPEC, SEED)
FREEZE = FreezeSkills(True)
DONE: tuple[Request, ...] = (
    *(TrialOnce() for _ in range(12)),
    FREEZE,
    SetParameter("learner.epsilon", 0.3),
    TrialOnce(),
    Branch(Place(0, 40), SetParameter("world.vision_radius", 6.0)),
    Branch(Place(0, 60), Explore("approach", 30, 0.5)),
    AddMark(Place(0, 30), "the <b>cone</b> closes"),
    NameLine(1, "wider"),
    MakeLive(1),
    FreezeSelection(True),
)


@pytest.fixture(scope="module")
def file() -> bytes:
    """A session with branches, marks and names, as somebody shares it."""
    session = Session(SPEC, "timed", SEED, FULL_SPEED, False, name_of=name_of)
    session.start()
    refusals: list[str] = []
    try:
        for request in DONE:
            session.submit(request, refusals.append)
            settle(session)
    finally:
        session.stop()
    assert refusals == []
    # The day is another one each time, and mutations are to be the same.
    shared_now = read_data(NAME, session.excerpt(None).data)
    return whole(replace(shared_now.header, began=HEADER.began), shared_now.records)


def linked(lines: bytes) -> str:
    """What a link holds that somebody made of these lines."""
    return base64.urlsafe_b64encode(zlib.compress(lines, 9)).decode().rstrip("=")


def made(written: Written, most_steps: int = shared.MOST_STEPS) -> str:
    """Make a session again; what is said of it."""
    remade = made_again(written, Budget(), name_of, first_number=1_000, most_steps=most_steps)
    return verdict_in_words(remade, contents_of(written))


# --- What is shared is there ---------------------------------------------------------------------


def test_a_file_and_a_link_say_the_same(file: bytes) -> None:
    written = read_shared(NAME, file)
    assert read_link(code_of(file)).records == written.records
    assert with_sums(without_sums(file)) == file
    assert contents_in_words(contents_of(written)).startswith(
        "timed, seed 5; 5 commands; 3 lines, the live one up to trial 3,001; written by pounce "
    )
    assert made(written) == "Digest as recorded: same."
    assert len(file) < 3_500
    assert len(code_of(file)) < 1_800


def test_what_differs_is_said_with_what_to_do_and_is_kept_as_it_is_here(file: bytes) -> None:
    written = read_shared(NAME, file)
    others = tuple(
        replace(record, digest="ab" * 32) if isinstance(record, Stood) and record.run else record
        for record in written.records
    )
    header = replace(written.header, version="0.0.1")
    theirs = read_data(NAME, whole(header, others))
    said = made(theirs)
    assert said.startswith("Digest as recorded: differs (wider, ")
    assert "learns otherwise than 0.0.1" in said
    assert "open it with pounce 0.0.1" in said
    here = made_again(theirs, Budget(), name_of, first_number=7)
    assert here.records == written.records
    assert replayed(here.records).is_same
    ours = replace(theirs, header=written.header)
    assert "The same version wrote it" in made(ours)
    assert made(replace(ours, records=ours.records[:1])) == (
        "No digest was recorded, so there is nothing to compare it with."
    )


# --- What means ill ------------------------------------------------------------------------------


def readings(data: bytes) -> list[Callable[[], Written]]:
    """By a file, by a link, and by what the lab itself keeps."""
    code = linked(packed(data))
    return [
        lambda: read_shared(NAME, data),
        lambda: read_link(code),
        lambda: read_data(NAME, data),
    ]


def tried(act: Callable[[], Made], refusal: type[Exception]) -> Made | None:
    """What comes of something; None where it is refused in words."""
    try:
        return act()
    except refusal as error:
        words = str(error)
    assert words
    return None


@pytest.mark.parametrize("part", range(PARTS))
def test_a_mutation_is_refused_in_words_or_made_within_bounds(
    file: bytes, part: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[int] = []
    advance = Run.advance

    def counted(run: Run, *args: int, **options: int) -> int:
        steps.append(advance(run, *args, **options))
        return steps[-1]

    monkeypatch.setattr(Run, "advance", counted)
    n_read = n_made = 0
    for seed in range(part, MUTATIONS, PARTS):
        for reading in readings(mutation(file, seed)):
            written = tried(reading, SessionError)
            if written is None:
                continue
            n_read += 1
            assert contents_in_words(contents_of(written))
            steps.clear()
            n_made += tried(partial(made, written, MOST_STEPS), SessionError) is not None
            assert sum(steps) <= MOST_STEPS
            tried(partial(replayed, written.records, 500, None, name_of), ReplayError)
    # It is not that the first check refuses all of them.
    assert n_read > MUTATIONS / PARTS / 4
    assert n_made > 0


def test_a_mutation_is_always_the_same_one(file: bytes) -> None:
    again = [mutation(file, seed) for seed in range(MUTATIONS)]
    assert again == [mutation(file, seed) for seed in range(MUTATIONS)]
    assert len(set(again)) > 0.9 * MUTATIONS


def refused(reading: Callable[..., object], args: tuple[Any, ...], message: str) -> None:
    with pytest.raises(SessionError, match=message):
        reading(*args)


def peak_of_refusing(message: str, reading: Callable[..., object], *args: Any) -> int:
    """Bytes that it takes at most to refuse something with a message."""
    return peak_of(refused, reading, args, message)


def test_what_is_too_large_is_not_unpacked_and_not_read(tmp_path: Path) -> None:
    bomb = linked(b"{" + b" " * 2**22)
    assert len(bomb) < MOST_CHARACTERS
    assert peak_of_refusing("the link: is too large; allowed", read_link, bomb) < 2**20
    in_bomb = base64.urlsafe_b64encode(zlib.compress(zlib.compress(b"0" * 2**24))).decode()
    assert peak_of_refusing("is no session", read_link, in_bomb.rstrip("=")) < 2**20
    path = tmp_path / "large.pounce"
    with path.open("wb") as large:
        large.truncate(2**33)
    assert peak_of_refusing("is too large; allowed: up to 256 KiB", read_file, path) < 2**20
    data = bytes(MOST_BYTES + 1)
    assert peak_of_refusing("theirs.pounce: is too large", read_shared, NAME, data) < 2**16


@pytest.mark.parametrize(
    "code",
    [
        *("", "a", "ab", "../s", "a b", "A" * (MOST_CHARACTERS + 1), "%00", "é", "="),
        *(linked(b""), linked(b"no session"), linked(b"{}\n")[:-3], linked(b"{}\n") + "AAAA"),
    ],
)
def test_a_link_that_is_not_whole_is_refused(code: str) -> None:
    with pytest.raises(SessionError, match=r"^the link: is "):
        read_link(code)
    plain = code.isascii() and 0 < len(code) <= MOST_CHARACTERS
    assert is_code(code) == (plain and code.replace("-", "").replace("_", "").isalnum())


def test_the_ends_of_a_file_that_was_cut_off_are_said(file: bytes) -> None:
    assert read_shared(NAME, file[:-1]).is_torn
    with pytest.raises(SessionError, match="no session"):
        read_shared(NAME, b"")


def test_what_is_no_file_is_refused(tmp_path: Path, file: bytes) -> None:
    path = tmp_path / "one.pounce"
    path.write_bytes(file)
    assert read_file(path).records == read(path).records
    for other in (tmp_path, tmp_path / "none", Path("/dev/zero")):
        with pytest.raises(SessionError, match="is no file"):
            read_file(other)


def many(command: Command, count: int) -> tuple[Record, ...]:
    return tuple(Gave(0, place, command) for place in range(count))


def with_episodes(count: int) -> SetSchedule:
    episodes = tuple(
        EpisodeSpec(skill="approach", at=2 * place, duration=1, probability=0.5)
        for place in range(count)
    )
    return SetSchedule(SPEC.schedule.model_copy(update={"episodes": episodes}))


@pytest.mark.parametrize(
    ("records", "message"),
    [
        ((BEGAN, *many(FREEZE, 2_000)), "has 2,001 records; allowed: up to 2,000"),
        ((replace(BEGAN, run=10**6),), "line 2, run: 1,000,000 is not allowed"),
        ((BEGAN, Gave(0, 2**62, FREEZE)), "line 3, step: 4,611,686,018,427,387,904 is not allowed"),
        ((BEGAN, Stood(0, 1, 2**53, "ab" * 32, 9)), "line 3, trial: 9,007,199,254,740,992"),
        ((BEGAN, Stood(0, 1, 0, "ab" * 32, 2**53)), "line 3, until_trial: "),
        ((BEGAN, Stood(0, 1, 0, "<b>", 9)), "line 3, digest: is none; allowed: 64 hexadecimal"),
        ((BEGAN, Marked(2**60, 0, 0, 0, "a")), "line 3, number: "),
        ((BEGAN, Branched(1, 2**40, 0, ())), "line 3, parent: "),
        ((BEGAN, Gave(0, 0, with_episodes(201))), "line 3, episodes: there are more than 200"),
        ((BEGAN, Branched(1, 0, 0, (with_episodes(201),))), "line 3, episodes: "),
        ((replace(BEGAN, preset="a\x1b[31m"),), "line 2, preset: is no name"),
        ((replace(BEGAN, preset="a\u202eb"),), "line 2, preset: is no name"),
        ((replace(BEGAN, preset="a" * 101),), "line 2, preset: is no name; allowed: up to 100"),
        ((replace(BEGAN, preset=""),), "line 2, preset: is no name"),
    ],
)
def test_what_no_session_of_this_program_says_is_refused(
    records: Sequence[Record], message: str
) -> None:
    with pytest.raises(SessionError, match=message):
        read_shared(NAME, whole(HEADER, records))


@pytest.mark.parametrize(
    "records",
    [
        (BEGAN, Stood(0, 90_000, 9, "ab" * 32, 9)),
        tuple(replace(BEGAN, run=number) for number in range(40)),
        (BEGAN, *(Branched(n, 0, 1, (FREEZE,), n - 1 if n > 1 else None) for n in range(1, 9))),
        (BEGAN, *many(SetParameter("world.vision_radius", 3.0), 20)),
        (
            BEGAN,
            *many(SetParameter("learner.epsilon", 0.3), 20),
            *(Gave(0, 19, Undo(number)) for number in range(1, 20)),
        ),
        (
            BEGAN,
            Branched(1, 0, 5, (FREEZE,)),
            *(part for n in range(1, 9) for part in (Marked(n, 1, n, 0, "a"), Unmarked(n))),
        ),
    ],
)
def test_what_takes_long_is_refused(records: Sequence[Record]) -> None:
    written = read_data(NAME, whole(HEADER, records))
    with pytest.raises(SessionError, match="takes more than 80,000 steps, as many as may be"):
        made(written, 80_000)


def test_a_key_that_is_there_twice_is_refused() -> None:
    lines = without_sums(whole(HEADER, (BEGAN, Gave(0, 1, FREEZE))))
    twice = with_sums(lines.replace(b'"step":1', b'"step":1,"step":2'))
    with pytest.raises(SessionError, match="line 3 is not JSON"):
        read_shared(NAME, twice)


def test_no_session_from_elsewhere_names_a_file_of_this_machine() -> None:
    took = TookLesson(
        0, "mine", "/home/me/mine.yaml", "1", LongText("title: A"), "en", 0, True, True
    )
    data = whole(HEADER, (BEGAN, took))
    assert read_data(NAME, data).records[1] == took
    (_, found) = read_shared(NAME, data).records
    assert found == replace(took, source="")
    (_, found) = read_link(code_of(data)).records
    assert found == replace(took, source="")


def test_texts_are_shown_and_not_obeyed() -> None:
    records = (BEGAN, NamedLine(0, "<script>alert(1)</script>"))
    written = read_shared(NAME, whole(HEADER, records))
    remade = made_again(written, Budget(), name_of)
    assert remade.made.family.live.name == "<script>alert(1)</script>"
    obeyed = read_shared(NAME, whole(HEADER, (BEGAN, NamedLine(0, "a\x1b[31m"))))
    with pytest.raises(SessionError, match="a name is one line of characters that can be read"):
        made(obeyed)
