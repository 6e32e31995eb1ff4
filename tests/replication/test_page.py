"""Pages from a template and numbers, and the pages of the documentation as they are kept."""

import pytest

from app.documents import experiments
from app.replication import plan
from app.replication.page import (
    HEADLINE_BEGINS,
    HEADLINE_ENDS,
    Found,
    Table,
    filled,
    page,
    with_headline,
)
from app.replication.write import FIGURES, NUMBERS, PAGE
from tests.support.pages import ROOT

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def kept() -> Found:
    return Found.from_json((DOCS / NUMBERS).read_text("utf-8"))


def test_the_page_is_what_its_numbers_make_of_it(kept: Found) -> None:
    assert (DOCS / PAGE).read_text("utf-8") == page(kept)


def test_the_headline_of_the_readme_is_what_these_numbers_make_of_it(kept: Found) -> None:
    readme = (ROOT / "README.md").read_text("utf-8")
    assert readme == with_headline(readme, kept)


def test_the_page_has_all_its_figures_and_no_other_is_kept() -> None:
    stems = {path.stem for path in (DOCS / FIGURES).glob("*.png")}
    assert {stem for stem in stems if not stem.startswith("beyond")} == {*plan.DRAWN}


def test_every_experiment_is_a_shipped_one() -> None:
    assert {*plan.EXPERIMENTS} <= experiments.shipped().keys()
    assert {experiment for experiment, _ in plan.DRAWN.values() if experiment} <= {
        *plan.EXPERIMENTS
    }


def test_numbers_come_back_from_their_file_as_they_were(kept: Found) -> None:
    assert Found.from_json(kept.to_json()) == kept


def test_a_template_has_numbers_and_tables_in_their_places() -> None:
    table = Table(("", "end"), [("a|b", "80.5"), ("c", "–")])
    found = Found(texts={"one: two": "3"}, tables={"ends": table})
    assert filled("{{one: two}} of\n{{ends}}\n", found) == (
        "3 of\n|  | end |\n| --- | --- |\n| a\\|b | 80.5 |\n| c | – |\n"
    )


def test_a_template_that_asks_for_what_did_not_come_out_is_refused() -> None:
    with pytest.raises(KeyError, match="nothing"):
        filled("{{nothing}}", Found())


def test_a_page_without_a_place_for_the_headline_is_refused(kept: Found) -> None:
    for readme in ("", HEADLINE_BEGINS, f"{HEADLINE_ENDS}{HEADLINE_BEGINS}"):
        with pytest.raises(ValueError, match="from the results"):
            with_headline(readme, kept)
