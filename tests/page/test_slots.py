"""HTML for the slots of the stage."""

from app.page.slots import slot_html


def test_a_slot_holds_its_html_where_nothing_of_it_is_seen() -> None:
    assert slot_html("task", "<b>x</b>") == '<template data-slot="task"><b>x</b></template>'
