"""Colours of lines and cells can be told apart, on light pages and on dark ones."""

import colorsys
import itertools
import re

import pytest

from app.charts.page.colours import colour_of, style_sheet
from app.charts.styles import THESIS_STYLES, Style, style_of, styles_of
from app.results.gather import MOST_CURVES
from tests.support.charts import luminance


def colours_on_pages(name: str) -> tuple[str, str]:
    """What a name of a colour stands for on a light page, and on a dark one."""
    light, dark = re.findall(r"\.pounce-results\{(--[^}]*)\}", style_sheet())
    key = name.removeprefix("var(").removesuffix(")")
    found = [dict(rule.split(":") for rule in rules.split(";") if rule) for rules in (light, dark)]
    return found[0][key], found[1][key]


@pytest.mark.parametrize("style", [*THESIS_STYLES.values(), *map(style_of, range(8))])
def test_lines_stand_out_from_white_and_from_nearly_black(style: Style) -> None:
    name = colour_of(style)
    if name != "currentColor":
        on_white, on_dark = (luminance(colour) for colour in colours_on_pages(name))
        assert 1.05 / (on_white + 0.05) >= 3
        # As the dots of runs are drawn, which are small and a little transparent.
        dark = luminance("#242424")
        assert (0.75 * on_dark + 0.25 * dark + 0.05) / (dark + 0.05) >= 3.5


def test_the_learners_of_the_thesis_look_as_there() -> None:
    presets = ["standard_q", "hierarchical_3", "timed", "hierarchical_2"]
    assert styles_of(presets) == [THESIS_STYLES[preset] for preset in presets]


def test_several_variants_of_one_preset_are_told_apart() -> None:
    styles = styles_of(["timed"] * 4)
    assert len({colour_of(style) for style in styles}) == 4


def _hue(colour: str) -> float:
    """In degrees."""
    return 360 * colorsys.rgb_to_hsv(*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)))[0]


def test_lines_of_the_same_hue_differ_in_their_dashes() -> None:
    styles = styles_of(["timed"] * MOST_CURVES)
    coloured = [
        (_hue(colours_on_pages(name)[0]), style.dashes)
        for style in styles
        if (name := colour_of(style)) != "currentColor"
    ]
    for (hue, dashes), (other, others_dashes) in itertools.combinations(coloured, 2):
        apart = abs(hue - other)
        assert min(apart, 360 - apart) > 10 or dashes != others_dashes
