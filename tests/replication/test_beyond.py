"""The page on what goes beyond the thesis, and its part that is from the results."""

from pathlib import Path

import pytest

from app.documents import experiments
from app.experiments.store import REPORT_PAGE, figures_of
from app.replication.beyond import NUMBERS, PAGE, PAGES, beyond_in, write_beyond
from app.replication.page import HEADLINE_BEGINS, HEADLINE_ENDS, Found, with_place
from app.replication.plan import BEYOND
from app.results.read import ResultsError
from tests.support.folders import add_run, new_folder
from tests.support.pages import ROOT

NAME, TEMPLATES = BEYOND


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs of each of the shipped experiment's variants, made up."""
    out = tmp_path_factory.mktemp("results")
    for name in BEYOND:
        _make_up(new_folder(out / name), name)
    return out


def _make_up(folder: Path, name: str) -> None:
    for variant in experiments.load(name).variants:
        level = 10.0 if variant.preset == "timed" else 20.0
        for seed in range(2):
            made_up = dict.fromkeys(
                ("horizon_area", "horizon_reward", "horizon_greedy"), level + seed
            )
            add_run(folder, seed, variant.preset, variant.label, variant.overrides, **made_up)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_what_its_template_makes_of_the_kept_numbers(page: str) -> None:
    text = (ROOT / "docs" / page).read_text("utf-8")
    kept = Found.from_json((ROOT / "docs" / NUMBERS).read_text("utf-8"))
    assert with_place(text, PAGES[page], kept) == text


def test_learners_are_set_against_the_timed_one_in_each_world(out: Path) -> None:
    found = beyond_in(out / NAME)
    header, *rows = [found.tables["standard"].header, *found.tables["standard"].rows]
    assert header[:2] == ("learner", "area")
    assert len(rows) == 13
    assert rows[-1][0] == "`timed`"
    leads = found.tables["leads: horizon_area"]
    assert len(leads.header) == 6
    assert "`timed`" not in {row[0] for row in leads.rows}
    assert {cell for row in leads.rows for cell in row[1:]} == {"10.0 [10.0, 10.0]"}


def test_the_part_between_the_marks_is_written_anew_with_its_figures(
    out: Path, tmp_path: Path
) -> None:
    figures = figures_of(out / NAME / REPORT_PAGE)
    figures.mkdir(exist_ok=True)
    (figures / "standings.png").write_bytes(b"a picture")
    docs = tmp_path / "docs"
    (docs / "figures").mkdir(parents=True)
    (docs / "beyond").mkdir()
    for page in PAGES:
        (docs / page).write_text(f"before\n{HEADLINE_BEGINS}\nas it was\n{HEADLINE_ENDS}\nafter\n")
    assert write_beyond(out, docs) == docs / PAGE
    text = (docs / PAGE).read_text("utf-8")
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "as it was" not in text
    assert "| `feudal` |" in text
    assert "{{" not in text
    assert (docs / "figures" / "beyond.png").read_bytes() == b"a picture"
    drawn = {file.stem for file in (docs / "figures").iterdir()}
    kept = {file.stem for file in (ROOT / "docs" / "figures").glob("beyond*.png")}
    assert drawn == kept


def test_results_without_some_learner_in_some_world_are_refused(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / NAME)
    add_run(folder, 0, "timed", "timed, standard")
    with pytest.raises(ResultsError, match="not each learner in each world"):
        beyond_in(folder)
