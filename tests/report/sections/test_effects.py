"""Reports on searches and on designs of many settings: what matters, in words and in pictures."""

import itertools
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tests.support.folders import add_run, new_folder
from tests.support.reports import page_of, pictures_of, table_of, text_of, without_pictures

ALPHA, EPSILON, GAMMA = "learner.alpha", "learner.epsilon", "learner.gamma"
N_DRAWS = 24


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(tmp_path / "searched", metrics=["final_reward", "area"])


def add_draws(folder: Path) -> list[float]:
    """Draws of three settings, of which the first alone makes a difference; the first setting."""
    alphas = np.random.default_rng(0).permutation(N_DRAWS) / N_DRAWS
    others = np.random.default_rng(1).random((N_DRAWS, 2)).round(3)
    for number, (alpha, (epsilon, gamma)) in enumerate(zip(alphas, others, strict=True), 1):
        for seed in range(2):
            add_run(
                folder,
                seed,
                "timed",
                f"timed, draw {number}",
                {ALPHA: float(alpha), EPSILON: float(epsilon), GAMMA: float(gamma)},
                final_reward=float(80 * alpha + (number * 7 % 11) / 5 + seed),
                area=None,
            )
    return [float(alpha) for alpha in alphas]


class Searched(NamedTuple):
    """A search over three settings and the page on it."""

    folder: Path
    page: str
    alphas: list[float]


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> Searched:
    folder = new_folder(
        tmp_path_factory.mktemp("results") / "searched", metrics=["final_reward", "area"]
    )
    alphas = add_draws(folder)
    with pytest.MonkeyPatch.context() as patch:
        without_pictures(patch)
        return Searched(folder, page_of(folder), alphas)


def test_a_search_says_which_settings_matter_and_which_do_not(searched: Searched) -> None:
    text = text_of(searched.page)
    assert "Search over 3 settings of timed" in text
    assert f"By itself matters: {ALPHA} (" in text
    assert "No effect by itself can be seen of: " in text
    assert "No pair of them can be seen to matter beyond that." in text
    assert f"n = {N_DRAWS} draws, each the mean of its runs" in text
    assert "area under the curve of timed" not in text  # which was not measured


def test_a_search_is_drawn_setting_by_setting_and_pair_by_pair(searched: Searched) -> None:
    names = pictures_of(searched.folder)
    assert {f"{kind}_1_final_reward" for kind in ("trends", "shares")} <= {*names}
    # Neither a plane of thirty by thirty cells, nor each draw beside the first.
    assert not any(name.startswith(("plane", "variants")) for name in names)


def test_the_best_draws_come_with_their_settings(searched: Searched) -> None:
    rows = table_of(searched.page, "draw")
    assert len(rows) == 10
    best = searched.alphas.index(max(searched.alphas)) + 1
    assert rows[0]["draw"] == f"timed, draw {best}"
    assert rows[0][ALPHA] == f"{max(searched.alphas):g}"
    luck = "Chosen by all seeds but one, and measured by the one left out, it has"
    assert luck in text_of(searched.page)


def test_numbers_of_a_search_are_in_files(searched: Searched) -> None:
    figures = searched.folder / "report_figures"
    first, *rows = (figures / "shares_1_final_reward.csv").read_text("utf-8").splitlines()
    assert first == "setting,with,share of the variance of final reward,p"
    assert len(rows) == 3 + 3
    trends = (figures / "trends_1_final_reward.csv").read_text("utf-8")
    assert sum(",variant," in row for row in trends.splitlines()) == 3 * N_DRAWS


def test_few_draws_are_listed_and_nothing_is_made_of_them(folder: Path) -> None:
    for number in (1, 2):
        overrides = {ALPHA: number / 10, EPSILON: 0.3 - number / 10}
        add_run(folder, 0, "timed", f"timed, draw {number}", overrides, area=None)
    page = page_of(folder)
    assert "Search over 2 settings of timed" in text_of(page)
    assert len(table_of(page, "draw")) == 2
    assert not any(name.startswith("trends") for name in pictures_of(folder))


def test_all_combinations_say_how_much_each_setting_and_pair_accounts_for(folder: Path) -> None:
    for alpha, epsilon, gamma in itertools.product((0.1, 0.2, 0.3), (0, 0.2), (0.8, 0.9)):
        overrides = {ALPHA: alpha, EPSILON: epsilon, GAMMA: gamma}
        label = f"timed, {', '.join(f'{k}={v}' for k, v in overrides.items())}"
        value = 100 * alpha + 1_000 * (epsilon - 0.1) * (gamma - 0.85)
        add_run(folder, 0, "timed", label, overrides, final_reward=value, area=None)
    text = text_of(page_of(folder))
    assert "Each setting of timed" in text
    assert f"By itself matters: {ALPHA} (" in text
    assert f"Beyond that, some matter together: {EPSILON} with {GAMMA} (" in text
    assert "shares_1_final_reward" in pictures_of(folder)
