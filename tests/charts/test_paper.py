"""Pictures: what is drawn where, in which colour, and with how much room."""

import contextlib
import csv
import io
import itertools
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen

from app.analysis.axles import Axle, grouped
from app.analysis.estimates import Band, Estimate
from app.charts.model import (
    Chart,
    Curves,
    Dot,
    Dots,
    Effect,
    Effects,
    Line,
    Mark,
    Panel,
    Plane,
    Points,
    RunDot,
    Series,
    ValueMap,
    ValueMaps,
)
from app.charts.paper import fonts
from app.charts.paper.curves import curves_figure
from app.charts.paper.drawing import Drawing, _saved, drawn, missing_note
from app.charts.paper.plane import scale_around_zero
from app.charts.paper.values import value_colours
from app.charts.styles import style_of
from learners.measures import FoldedValue
from sim import geometry
from sim.spec import WorldSpec

LONG = ", ".join(f"schedule.skills.circle_clockwise.freeze{k}=12000" for k in range(12))
EDGES = geometry.ring_edges(WorldSpec())
NOTHING = (244, 245, 247)


def png_of(distance: np.ndarray, share: np.ndarray) -> np.ndarray:
    """(y, x, 4) float32: the picture of one map without its scale, the first row at the top."""
    from matplotlib import image

    map_ = ValueMap("a moment", FoldedValue(distance, share), 3)
    drawing = drawn("value", ValueMaps([map_], EDGES, 27), "small print")
    picture = image.imread(io.BytesIO(drawing.png))
    return picture[:, : picture.shape[1] * 3 // 4]


def middle_of(picture: np.ndarray, colour: tuple[int, int, int]) -> tuple[float, float]:
    """Mean place of all pixels of a colour, (x to the right, y upwards) in pixels."""
    same = np.abs(picture[:, :, :3] * 255 - colour).max(axis=2) < 3
    rows, columns = np.nonzero(same)
    assert rows.size > 100
    return float(columns.mean()), float(-rows.mean())


@pytest.mark.parametrize(
    ("direction", "to"), [(0, (1, 0)), (6, (0, 1)), (12, (-1, 0)), (18, (0, -1))]
)
def test_directions_go_counter_clockwise_from_the_right(
    direction: int, to: tuple[int, int]
) -> None:
    # All is known but for one sector, so that only there the paper is bare.
    share = np.ones((18, 24))
    share[:, direction] = 0
    picture = png_of(np.where(share > 0, 50.0, np.nan), share)
    bare = middle_of(picture, NOTHING)
    there = middle_of(picture, tuple(value_colours(np.array(50.0), np.array(1.0))))
    offset = np.array(bare) - there
    assert np.argmax(np.abs(offset)) == np.argmax(np.abs(to))
    assert offset @ to > 100


def test_near_is_bright_and_far_is_dark_and_few_are_pale() -> None:
    near, far = value_colours(np.array([1.0, 150.0]), np.array([1.0, 1.0])).astype(int)
    assert near.sum() > far.sum()
    pale = value_colours(np.array([150.0]), np.array([0.1]))[0].astype(int)
    assert np.abs(pale - NOTHING).max() < np.abs(far - NOTHING).max()
    assert tuple(value_colours(np.array([np.nan]), np.array([0.0]))[0]) == NOTHING


# --- Planes of differences -----------------------------------------------------------------------


def difference(value: float, arm: float) -> Estimate:
    return Estimate(value, value - arm, value + arm, 5)


def of_difference(share: float) -> np.ndarray:
    """The colour at a share of the scale of differences, (3,) from 0 to 1."""
    norm, colours = scale_around_zero([1.0])
    return np.asarray(colours(norm(2 * share - 1))[:3])


def test_differences_are_coloured_around_zero_however_lopsided_they_are() -> None:
    """The lowest is as dark as it gets, and +1 is nearly the grey of 0, however light +20 is."""
    from matplotlib import image

    axles = Axle("x", (1, 2, 3)), Axle("y", (1,))
    cells = {(0, 0): difference(-20.0, 1), (2, 0): difference(1.0, 0.5)}
    chart = Plane(axles, "difference", cells, framed=(1, 0), is_difference=True)
    drawing = drawn("plane", chart, "small print")
    picture = image.imread(io.BytesIO(drawing.png))[:, :, :3]
    # The scale beside the cells has all colours, in the right third of the picture.
    cells_only = picture[:, : picture.shape[1] * 2 // 3].reshape(-1, 3)
    for at in (0.0, 0.5, (1 + 1 / 20) / 2):
        assert (np.abs(cells_only - of_difference(at)).max(axis=1) < 0.01).sum() > 1_000
    assert not (np.abs(cells_only - of_difference(1.0)).max(axis=1) < 0.01).any()
    rows = drawing.csv.splitlines()
    assert rows[1:] == ["1,1,-20.0,-21.0,-19.0,5", "3,1,1.0,0.5,1.5,5"]


def test_a_copy_in_black_and_white_keeps_the_sign_of_a_difference() -> None:
    greys = [of_difference(at) @ (0.299, 0.587, 0.114) for at in np.linspace(0, 1, 41)]
    steps = np.diff(greys)
    assert (steps > 0).all()
    assert steps.max() < 3 * steps.min()


def test_negative_numbers_have_the_same_minus_in_both_planes() -> None:
    axles = Axle("x", (1, 2)), Axle("y", (1,))
    cells = {(0, 0): difference(-0.4, 0.1), (1, 0): difference(0.0, 0.1)}
    texts = []
    for chart in (
        Plane(axles, "what", cells),
        Plane(axles, "what", cells, framed=(1, 0), is_difference=True),
    ):
        with drawn_figures() as found:
            drawn("a", chart, "")
        texts.append([text.get_text() for text in found[0].axes[0].texts])
    assert "\u22120.4" in texts[0]
    assert "\u22120.400" in texts[1]


def test_an_interval_that_does_not_exist_excludes_nothing() -> None:
    assert difference(-2.0, 1).excludes_zero
    assert difference(2.0, 1).excludes_zero
    assert not difference(1.0, 1).excludes_zero
    assert not Estimate(5.0, np.nan, np.nan, 1).excludes_zero


def test_large_whole_values_have_a_comma() -> None:
    shown = [grouped(value) for value in (999, 1_500, 24_000, 0.95, "a", -2_000)]
    assert shown == ["999", "1,500", "24,000", "0.95", "a", "-2,000"]


# --- Rows and axes -------------------------------------------------------------------------------


@contextlib.contextmanager
def drawn_figures() -> Iterator[list[Any]]:
    """Figures as they are drawn, to be looked at after."""
    found: list[Any] = []

    def kept(name: str, figure: Any, *more: Any) -> Drawing:
        saved = _saved(name, figure, *more)
        found.append(figure)
        return saved

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("app.charts.paper.drawing._saved", kept)
        yield found


@pytest.fixture
def figures() -> Iterator[list[Any]]:
    """Figures as they are drawn, to be looked at after."""
    with drawn_figures() as found:
        yield found


# --- Texts in any script -------------------------------------------------------------------------


def six_drawings(label: str) -> list[Drawing]:
    """A drawing of each kind, the label wherever a text may stand."""
    some = Estimate(1.0, 0.5, 1.5, 3)
    band = Band(*(np.array([k]) for k in (0, 10, 1.0, 0.5, 1.5, 3)))
    line = Line(label, band, style_of(0), 3, [Mark(5, label)])
    axles = Axle(label, (label, "b")), Axle("y", (1, 2))
    value = FoldedValue(np.full((18, 24), 50.0), np.ones((18, 24)))
    charts: Sequence[Chart] = [
        Curves("steps", [Panel(label, [line])]),
        Dots({label: [Dot(label, some)]}),
        Points(axles[0], label, [Series(label, [some, some])]),
        Plane(axles, label, {(0, 0): some}),
        Effects(label, [Effect(axles[0], [some, some])]),
        ValueMaps([ValueMap(label, value, 3)], EDGES, 27),
    ]
    return [drawn(name, chart, label) for name, chart in zip("abcdef", charts, strict=True)]


def texts_of(svg: str) -> list[str]:
    found = (element for element in ET.fromstring(svg).iter() if element.tag.endswith("}text"))
    return ["".join(element.itertext()) for element in found]


@pytest.fixture
def no_fonts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine on which no font is installed but that of matplotlib."""
    monkeypatch.setattr(fonts, "system_fonts", lambda: ())


@pytest.mark.filterwarnings("error")
@pytest.mark.usefixtures("no_fonts")
def test_texts_stay_texts_and_characters_without_a_font_are_named() -> None:
    label = "漢字 \U0001f98a ε, $x$"
    for drawing in six_drawings(label):
        assert drawing.missing == "漢字\U0001f98a"
        assert any(label in text for text in texts_of(drawing.svg))
        assert "漢字" in drawing.csv
    note = missing_note("漢字\U0001f98a")
    assert note.startswith("No font of this machine has 漢, 字, \U0001f98a: boxes in PNG files;")
    assert missing_note("") == ""
    assert "㐀, 㐁" in (many := missing_note("".join(map(chr, range(0x3400, 0x3500)))))
    assert "and 236 more" in many


@pytest.mark.usefixtures("no_fonts")
def test_a_character_that_is_there_or_has_no_picture_is_not_missing() -> None:
    label = "Größe, Ω ≥ שלום مرحبا\u200f\ufe0f"
    drawing = six_drawings(label)[1]
    assert drawing.missing == ""
    assert any("Größe, Ω ≥ שלום مرحبا" in text for text in texts_of(drawing.svg))


def font_with(path: Path, family: str, characters: str) -> str:
    """A font in which each of some characters is a block."""
    pen = TTGlyphPen(None)
    for number, point in enumerate([(0, 0), (0, 800), (900, 800), (900, 0)]):
        pen.lineTo(point) if number else pen.moveTo(point)
    pen.closePath()
    names = [".notdef", *(f"uni{ord(c):04X}" for c in characters)]
    font = FontBuilder(1000, isTTF=True)
    font.setupGlyphOrder(names)
    font.setupCharacterMap({ord(c): f"uni{ord(c):04X}" for c in characters})
    font.setupGlyf(dict.fromkeys(names, pen.glyph()))
    font.setupHorizontalMetrics(dict.fromkeys(names, (1000, 0)))
    font.setupHorizontalHeader(ascent=800, descent=-200)
    font.setupNameTable({"familyName": family, "styleName": "Regular"})
    font.setupOS2()
    font.setupPost()
    font.save(path)
    return str(path)


@pytest.mark.filterwarnings("error")
def test_a_font_that_is_installed_is_taken_for_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fonts with more of it come first, and what cannot be read is passed over."""
    broken = tmp_path / "broken.ttf"
    broken.write_bytes(b"no font")
    installed = (
        str(broken),
        font_with(tmp_path / "less.ttf", "Less of it", "漢"),
        font_with(tmp_path / "more.ttf", "More of it", "漢字"),
        str(tmp_path / "gone.ttf"),
    )
    label = "漢字"
    monkeypatch.setattr(fonts, "system_fonts", lambda: ())
    without = six_drawings(label)[0]
    monkeypatch.setattr(fonts, "system_fonts", lambda: installed)
    assert fonts.fonts_for("a 漢字 仮") == fonts.Fonts((fonts.FAMILY, "More of it"), "仮")
    drawing = six_drawings(label)[0]
    assert (without.missing, drawing.missing) == ("漢字", "")
    assert drawing.png != without.png
    # A browser looks for fonts of its own.
    assert "More of it" not in drawing.svg


def test_what_a_text_says_is_not_taken_for_a_part_of_the_picture() -> None:
    label = """<b id="patch_1"> & url(#patch_1) 'x' font-family: serif"""
    for drawing in six_drawings(label)[:4]:
        assert any(text.startswith(label[:20]) for text in texts_of(drawing.svg))
        tags = re.sub(">[^<]*<", "><", drawing.svg)
        assert tags.count("font-family") == 1
        names = re.findall(r'\bid="([^"]+)"', tags)
        assert len(names) == len(set(names))


@pytest.mark.usefixtures("no_fonts")
def test_chinese_labels_have_the_room_that_they_need(figures: list[Any]) -> None:
    six_drawings("先学接近" * 5)
    for figure in figures:
        sheet = figure.bbox
        for text in [*figure.texts, *(t for legend in figure.legends for t in legend.texts)]:
            box = text.get_window_extent()
            assert box.x0 >= sheet.x0
            assert box.x1 <= sheet.x1


def test_a_curve_and_its_marks_lie_where_their_numbers_are() -> None:
    starts = np.array([0, 100_000, 200_000, 300_000])
    mean = np.array([10.0, -20.0, 60.0, 55.0])
    band = Band(starts, starts + 100_000, mean, mean - 3, mean + 4, np.array([3, 3, 2, 1]))
    line = Line("a", band, style_of(0), 3, [Mark(250_000, "avoid")])
    (axes,) = curves_figure(Curves("steps", [Panel("", [line])]), "small print").axes
    curves = [drawn for drawn in axes.lines if drawn.get_zorder() == 3]
    whole, rest = (np.asarray(drawn.get_xydata()) for drawn in curves)
    assert whole == pytest.approx(np.array([[0.05, 10.0], [0.15, -20.0]]))
    assert rest == pytest.approx(np.array([[0.15, -20.0], [0.25, 60.0], [0.35, 55.0]]))
    (mark,) = (drawn.get_xdata() for drawn in axes.lines if drawn.is_dashed())
    assert list(mark) == pytest.approx([0.25, 0.25])
    (shade,) = (area.get_paths()[0].vertices for area in axes.collections)
    for x, low, high in zip(band.at * 1e-6, band.low, band.high, strict=True):
        at = np.asarray(shade)[np.isclose(np.asarray(shade)[:, 0], x), 1]
        assert (at.min(), at.max()) == (low, high)
    assert axes.get_xlabel() == "simulation steps (millions)"


def test_all_panels_of_a_figure_have_the_same_scales() -> None:
    panels: list[Panel] = []
    for n_windows, height in ((2, 10.0), (5, 80.0)):
        starts = np.arange(n_windows) * 100_000
        mean = np.full(n_windows, height)
        band = Band(starts, starts + 100_000, mean, mean, mean, np.full(n_windows, 3))
        panels.append(Panel("", [Line("a", band, style_of(0), 3)]))
    short, long = curves_figure(Curves("steps", panels), "small print").axes
    assert short.get_xlim() == long.get_xlim() == pytest.approx((0, 1.02 * 0.5))
    assert short.get_ylim() == long.get_ylim()
    assert long.get_ylim()[1] > 80


@pytest.mark.parametrize("n_panels", [1, 3])
def test_the_small_print_can_be_read_on_paper(n_panels: int, figures: list[Any]) -> None:
    band = Band(*(np.array([k]) for k in (0, 10, 1.0, 0.5, 1.5, 3)))
    line = Line("a", band, style_of(0), 3)
    words = "What is shaded is an interval. " * 20
    panels = [Panel(str(k), [line]) for k in range(n_panels)]
    drawn("a", Curves("steps", panels), words)
    (figure,) = figures
    (small,) = figure.texts
    assert " ".join(small.get_text().split()) == words.strip()
    on_paper = min(7.3 / figure.get_figwidth(), 1)
    assert small.get_fontsize() * on_paper > 5.8
    box = small.get_window_extent()
    assert box.y0 >= 0
    assert box.x1 <= figure.bbox.x1


def test_long_names_of_rows_do_not_run_into_one_another(figures: list[Any]) -> None:
    dots = [Dot(f"{k}, {LONG}", Estimate(k, k - 1, k + 1, 3)) for k in range(5)]
    rows = drawn("rows", Dots({LONG: dots, "another": dots}), "small print")
    axes = figures[0].axes[0]
    boxes = [label.get_window_extent() for label in axes.get_yticklabels()]
    assert all(low.y1 < high.y0 for high, low in itertools.pairwise(boxes))
    # What does not fit is in the numbers.
    assert f"{LONG}" in rows.csv


def test_titles_of_axes_have_two_lines_at_most(figures: list[Any]) -> None:
    some = Estimate(1.0, 0.5, 1.5, 3)
    axles = Axle(LONG, (1, 2)), Axle(LONG, (1, 2, 3))
    drawn("a", Dots({LONG: [Dot("b", some)]}), "")
    drawn("b", Points(axles[0], LONG, [Series("c", [some, some])]), "")
    drawn("c", Plane(axles, LONG, {(0, 0): some}), "")
    drawn("d", Effects(LONG, [Effect(axle, [some] * len(axle.values)) for axle in axles]), "")
    titles = [
        title
        for figure in figures
        for a in figure.axes
        for title in (a.get_xlabel(), a.get_ylabel())
    ]
    assert max(title.count("\n") for title in titles) == 1


def test_each_setting_has_a_plot_and_its_numbers(figures: list[Any]) -> None:
    effects = [
        Effect(Axle(f"key{k}", values), [Estimate(k, k - 1, k + 1, 4)] * 3)
        for k, values in enumerate(
            [(1, 10, 100), ("a", "b", "c"), (0, 1, 1000), (1, 2, 3), (4, 5, 6)]
        )
    ]
    rows = list(csv.reader(drawn("e", Effects("what", effects), "").csv.splitlines()))
    assert rows[0] == ["setting", "value", "what", "low", "high", "n"]
    assert rows[1:4] == [["key0", value, "0", "-1", "1", "4"] for value in ("1", "10", "100")]
    assert len(rows) == 1 + 5 * 3
    shown = [axes for axes in figures[0].axes if axes.get_visible()]
    assert [axes.get_xlabel() for axes in shown] == [f"key{k}" for k in range(5)]
    assert shown[0].get_xscale() == "log"


def test_each_run_of_a_figure_says_what_it_is_under_the_pointer() -> None:
    runs = [RunDot(1.5, 3), RunDot(math.nan, 4), RunDot(2.5, 5)]
    mean = Estimate(2.0, 1.0, 3.0, 2)
    found = drawn("dots", Dots({"reward": [Dot("a <b>", mean, runs), Dot("c", mean)]}), "")
    titles = re.findall(r"<use [^>]*><title>([^<]*)</title></use>", found.inline)
    assert titles == ["a &lt;b&gt;, seed 3: 1.50", "a &lt;b&gt;, seed 5: 2.50"]
    ET.fromstring(found.svg)
