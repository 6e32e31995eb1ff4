"""What the compiled loop is measured by: the same work in C, the same learning in Python."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from app.documents import presets
from benchmarks import audience, beside, load, own, page, scrub, side, soak, speeds
from benchmarks.compare import (
    c_program,
    compare,
    incomparable,
    time_c,
    time_kernel,
    time_plain,
    time_python,
)
from benchmarks.plain import PlainRun
from learners.spec import RunSpec
from tests.support.costs import try_for_a_moment
from tests.support.endless import WORLD

SMALL = ("world.size=40", "world.step_limit=60", "trials=600")
EARLY = (
    "schedule.skills.approach.freeze=20",
    "schedule.skills.circle_clockwise={at: 100, freeze: 20}",
    "schedule.skills.avoid={at: 250, freeze: 20}",
    "schedule.episodes.0.duration=200",
)
"""The timed schedule within so many trials."""
SOON = (
    "schedule.skills.circle_clockwise={at: 150}",
    "schedule.episodes.0.duration=100",
    "schedule.episodes.1.duration=300",
)
"""The schedule that was searched for, likewise."""
SPIRAL = (
    "learner.custom_skills={spiral_in: {approach: 0.5, circle_clockwise: 1}}",
    "learner.options=[approach, spiral_in]",
    "schedule.skills.spiral_in={at: 200, freeze: 50}",
)
UNSAFE = (*EARLY, "schedule.safe_introduction=false", "learner.initial_q=1")
EPISODES = [
    f"{{skill: approach, at: {trial}, duration: 1, probability: 1}}" for trial in range(100)
]
OFTEN = (f"schedule.episodes=[{', '.join(EPISODES)}]",)

PRESETS = {
    "standard_q": ("standard_q", ()),
    "hierarchical_2": ("hierarchical_2", ()),
    "hierarchical_3": ("hierarchical_3", ()),
    "timed": ("timed", EARLY),
    "timed_early": ("timed_early", SOON),
    "a skill of one's own": ("hierarchical_2", SPIRAL),
    "unsafe introduction": ("timed", UNSAFE),
    "other rings, and circles that spiral": (
        "hierarchical_2",
        ("world.ring_exponent=2.3", "world.n_distances=9", "learner.spiral_penalty=0.05"),
    ),
    "a hundred explorations": ("hierarchical_2", OFTEN),
}


def spec_of(name: str) -> RunSpec:
    preset, settings = PRESETS[name]
    return presets.load(preset, [*SMALL, *settings])


def steps_of_python_agent(spec: RunSpec) -> int:
    timed, _ = time_python(spec, 0)
    return timed.steps


def endless(name: str = "timed") -> RunSpec:
    """A preset of which a few trials take a moment, and all are never over."""
    return presets.load(name, ["trials=2000000", *(f"{key}={WORLD[key]}" for key in WORLD)])


@pytest.fixture(autouse=True)
def short_pilots(monkeypatch: pytest.MonkeyPatch) -> None:
    try_for_a_moment(monkeypatch)


@pytest.fixture(scope="module")
def program() -> Iterator[Path]:
    """The C program; tests that need it are skipped where there is no C compiler."""
    notes: list[str] = []
    with c_program(notes) as built:
        if built is None:
            pytest.skip(notes[0])
        yield built


def test_every_shipped_preset_is_compared_that_the_programs_know() -> None:
    known = {name for name in presets.shipped() if incomparable(presets.load(name)) is None}
    assert {"standard_q", "hierarchical_2", "hierarchical_3", "timed"} <= known
    assert known <= PRESETS.keys()


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("seed", [0, 1])
def test_the_c_program_does_the_work_of_the_compiled_loop(
    program: Path, name: str, seed: int
) -> None:
    spec = spec_of(name)
    (_, ours), (_, c) = time_kernel(spec, seed), time_c(program, spec, seed)
    assert c == ours
    assert ours.captures + ours.flights + ours.timeouts == spec.trials


@pytest.mark.parametrize("name", PRESETS)
def test_the_plain_loop_learns_a_preset(name: str) -> None:
    spec = spec_of(name)
    steps, *ends = PlainRun(spec).run(0)
    assert sum(ends) == spec.trials
    assert all(ends)
    assert time_plain(spec, 0).steps == steps


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        (
            "world.skill_n_distances=9",
            "world.skill_n_distances: skills see",
        ),
        (
            "world.skill_n_directions=8",
            "world.skill_n_distances: skills see",
        ),
        ("learner.local_rewards=binary", "learner.local_rewards: value 'binary'; allowed: signed"),
        ("learner.skills_that_learn=all", "learner.skills_that_learn: value 'all'; allowed:"),
        ("learner.held={until: change}", "learner.held: value 'some'; allowed: none"),
        ("learner.applicable=0.5", "learner.applicable: value 0.5; allowed: none"),
        ("schedule.teach={trials: 300}", "schedule.teach: value 'some'; allowed: none"),
        ("schedule.pretrain=100", "schedule.pretrain: value 100; allowed: 0"),
        ("schedule.skills.avoid={at: null, introduce: {by: reach}}", "schedule.introduce: a rule"),
        (
            "schedule.episodes.0.where={value_at_most: 1}",
            "schedule.episodes.where: states in which an episode acts",
        ),
    ],
)
def test_a_preset_that_the_programs_do_not_know_is_not_compared(setting: str, said: str) -> None:
    assert incomparable(presets.load("timed")) is None
    assert said in str(incomparable(presets.load("timed", [setting])))


def test_an_unsafe_introduction_is_made_by_all() -> None:
    spec = spec_of("unsafe introduction")
    safely = spec.schedule.model_copy(update={"safe_introduction": True})
    safe = spec.model_copy(update={"schedule": safely})
    assert time_kernel(safe, 0)[1] != time_kernel(spec, 0)[1]
    assert PlainRun(safe).run(0) != PlainRun(spec).run(0)
    pytest.importorskip("gymnasium")
    assert steps_of_python_agent(safe) != steps_of_python_agent(spec)


@pytest.mark.parametrize("name", PRESETS)
def test_the_python_agent_learns_a_preset(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gymnasium")
    monkeypatch.setattr("benchmarks.compare.PYTHON_STEPS", 4_000)
    spec = spec_of(name)
    timed, trials = time_python(spec, 0)
    assert 4_000 <= timed.steps < 4_000 + spec.world.step_limit
    assert 0 < trials <= spec.trials


def test_a_comparison_has_every_ratio(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gymnasium")
    monkeypatch.setattr("benchmarks.compare.PYTHON_STEPS", 1_000)
    said: list[str] = []
    found = compare({"mine": spec_of("a skill of one's own")}, 2, said.append)
    assert min(v for v in found["learners"]["mine"].values() if v is not None) > 0
    assert None not in found["learners"]["mine"].values()
    assert said[-1] == "mine: the Python agent"


def test_the_page_is_measured_with_clients_and_without(monkeypatch: pytest.MonkeyPatch) -> None:
    # A proxy for the rest of the world has nothing to do with it.
    for name in ("http_proxy", "https_proxy", "all_proxy", "ws_proxy"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    monkeypatch.delenv("no_proxy", raising=False)
    monkeypatch.delenv("NO_PROXY", raising=False)
    for name, value in (("CLIENTS", (0, 2)), ("SECONDS", 0.01), ("TRIALS", 300)):
        monkeypatch.setattr(page, name, value)
    spec = spec_of("timed")
    found = page.compare_page(spec, "timed", {"timed": spec}, 1, lambda _: None)
    assert found["clients"].keys() == {"0", "2"}
    assert min(found["clients"].values()) > 0


def test_what_many_pages_cost_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "SECONDS", 0.01)
    for name, value in (("TRIALS", 3), ("ROUNDS", 1), ("CLICKS", 2)):
        monkeypatch.setattr(load, name, value)
    spec = endless()
    found = load.measure_load(spec, "timed", {"timed": spec}, 2, 1, lambda _: None)
    assert found.keys() == {"pages", "click_ms", "learner_share", "rss_mb"}
    assert found["pages"] == 2
    assert 0 < found["click_ms"]["p50"] <= found["click_ms"]["p95"] <= found["click_ms"]["max"]
    assert found["learner_share"] > 0
    assert found["rss_mb"] > 10


def test_what_an_audience_costs_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "SECONDS", 0.01)
    for name, value in (("ROUNDS", 1), ("CLICKS", 2)):
        monkeypatch.setattr(load, name, value)
    for name, value in (("TRIALS", 300), ("READ_S", 0.5)):
        monkeypatch.setattr(audience, name, value)
    # Here it learns, or those who look on are sent next to nothing, but in very long trials.
    spec = presets.load("timed", ["world.step_limit=100000", "world.vision_radius=0"])
    found = audience.measure_audience(spec, "timed", {"timed": spec}, 3, 1, lambda _: None)
    assert list(found) == [
        *("watchers", "click_ms", "class_click_ms", "kB_per_s_each", "learner_share")
    ]
    assert found["watchers"] == 3
    for took in (found["click_ms"], found["class_click_ms"]):
        assert 0 < took["p50"] <= took["p95"]
    assert found["kB_per_s_each"] > 0
    assert found["learner_share"] > 0


def test_what_learners_of_their_own_cost_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "SECONDS", 0.01)
    for name, value in (("TRIALS", 40_000), ("READ_S", 0.5), ("TAPS_PER_S", 10.0)):
        monkeypatch.setattr(own, name, value)
    spec = presets.load("timed")
    found = own.measure_own(spec, "timed", {"timed": spec}, 3, 1, lambda _: None)
    assert found.keys() == {"seats", "tap_ms", "steps_per_s_each", "learner_share"}
    assert found["seats"] == 3
    assert 0 < found["tap_ms"]["p50"] <= found["tap_ms"]["p95"]
    assert found["steps_per_s_each"] > 0
    assert found["learner_share"] > 0


def test_what_an_experiment_costs_the_learner_is_measured(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in (("ROUNDS", 1), ("MEASURED_S", 0.1), ("WARM_UP_S", 0.01)):
        monkeypatch.setattr(beside, name, value)
    beside.main(1)
    assert capsys.readouterr().out.startswith("1 at a time: the learner keeps ")


def test_walking_in_the_past_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("STEPS", 50_000), ("TURNS", 2), ("TURN_S", 0.05)):
        monkeypatch.setattr(scrub, name, value)
    said: list[str] = []
    found = scrub.measure_scrub(endless(), "timed", 1, said.append)
    assert found.keys() == {"moments_per_s", "p95_ms", "learner_share"}
    assert min(found.values()) > 0
    assert said == ["scrubbing: 1 of 2", "scrubbing: 2 of 2"]


def test_what_keeping_the_past_costs_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scrub, "_KEPT_STEPS", 1_000_000)
    assert scrub.share_beside_keeping(spec_of("timed"), 1) > 0


def test_memory_is_looked_at_while_people_walk_in_the_past(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(soak, "SECONDS", 0.1)
    monkeypatch.setattr(soak, "MOST_GROWN_MB", 1_000.0)
    assert soak.main(["--minutes", "2"]) == 0
    *minutes, grown = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in minutes] == ["minute 1", "minute 2"]
    assert grown.startswith("beside checkpoints, grown by ")


@pytest.mark.browser
def test_four_runs_are_shown_while_all_learn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(side, "TURN_S", 0.5)
    monkeypatch.setattr(side, "_endless", endless)
    told: list[str] = []
    # In a thread of its own, since that of the tests may have a browser already.
    with ThreadPoolExecutor(1) as executor:
        found = executor.submit(side.measure_side, 1, told.append).result()
    assert list(found) == ["boards", "shown_per_s", "steps_per_s", "learner_share"]
    assert found["boards"] == 4
    assert min(found.values()) > 0
    assert told == ["opening the page", "counting: 1 of 1"]


def test_learners_are_timed_beside_the_timed_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speeds, "STEPS", 20_000)
    said: list[str] = []
    wanted = {name: presets.load(name) for name in ("standard_q", "timed")}
    found = speeds.measure_speeds(wanted, 2, said.append)
    assert list(found["learners"]) == ["standard_q", "timed"]
    assert all(speed["ratio_to_timed"] > 0 for speed in found["learners"].values())
    assert list(found["watching"]) == ["novelty", "reach", "change"]
    assert all(share > 0 for share in found["watching"].values())
    assert said[:2] == ["standard_q: warming up", "standard_q: repetition 1 of 2"]
