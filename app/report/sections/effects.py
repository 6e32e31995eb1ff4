"""Sections of a report on designs of many settings: what each does, and what pairs do beyond that.

Settings were either combined, all of their values with one another, or drawn at random.
"""

import math
from collections.abc import Iterable, Mapping, Sequence

from app.analysis import effects, estimates
from app.analysis.axles import grouped
from app.analysis.effects import Analysis, Factor
from app.analysis.estimates import Contrast, Estimate, bootstrap_rng
from app.analysis.sweeps import Design, Values, design_of, highest_unseen
from app.charts.model import Effect, Effects, Shares, Trends
from app.charts.paper.drawing import drawn
from app.charts.wording import shown_estimate
from app.documents.samples import is_draw
from app.metrics import Metric
from app.report.document import Page, details, table
from app.report.parts import NO_INTERVAL, Shown
from app.results.read import Group, measured
from app.util.html import Markup, element, joined
from app.words.numbers import shown_number

_MOST_DRAWS = 10
"""Draws that are listed, those that came out highest."""
_LEAST_SHARE = 0.005
"""Of the variance; below it, a share is said to be nothing."""
_METHOD = (
    "Shares are of the variance between variants, each the mean of its runs. They come from a fit"
    " of one smooth function for each setting, added up: what a setting accounts for beyond all"
    " others, and a pair beyond the whole sum, less what chance would (omega squared). Whether it"
    " is more than chance is tested by F, corrected for the number of settings, or of pairs (Holm,"
    " 5 %)."
)


def write_designs(page: Page, by_preset: Mapping[str, Sequence[Group]], shown: Shown) -> set[str]:
    """Write a section for each preset of which three or more settings differ, or were drawn.

    Args:
        page: to write on.
        by_preset: all variants, by preset.
        shown: the numbers that are shown.

    Returns:
        The presets whose settings were drawn at random.
    """
    searched: set[str] = set()
    number = 0
    for preset, groups in by_preset.items():
        of_draws = [group for group in groups if is_draw(group.label)]
        if of_draws:
            factors = effects.factors_of([g.overrides for g in of_draws], _settings(of_draws))
            if len(factors) >= 2:
                number += 1
                searched.add(preset)
                _draws_section(page, number, preset, factors, of_draws, shown)
            continue
        design = design_of([group.overrides for group in groups], _settings(groups))
        if design is not None:
            number += 1
            _combinations_section(page, number, preset, design, groups, shown)
    return searched


def swept_metrics(groups: Iterable[Group], shown: Shown) -> list[Metric]:
    """What is shown of what was swept, as far as it was measured."""
    groups = list(groups)
    return [metric for metric in shown.swept if measured(groups, metric.column)]


def counts(of: Iterable[Estimate]) -> str:
    """How many runs some estimates rest on."""
    found = sorted({estimate.n for estimate in of})
    return str(found[0]) if len(found) == 1 else f"{found[0]} to {found[-1]}"


def _settings(groups: Sequence[Group]) -> Mapping[str, object]:
    return groups[0].runs[0].settings


# --- Drawn at random -----------------------------------------------------------------------------


def _draws_section(
    page: Page,
    number: int,
    preset: str,
    factors: Sequence[Factor],
    groups: Sequence[Group],
    shown: Shown,
) -> None:
    parts: list[Markup] = []
    for metric in swept_metrics(groups, shown):
        page.tell(f"looking at what was drawn: {metric.title}")
        found = effects.analysed(factors, [_mean(g.values(metric.column)) for g in groups])
        if found is not None:
            name = f"{number}_{metric.column}"
            parts += [
                element("p", in_words(found, metric.title, "draws")),
                _trends(page, name, preset, found, metric),
                _shares(page, name, preset, found, metric, "draws"),
            ]
        parts.append(_best_draws(factors, groups, metric))
    if parts:
        page.say(f"Search over {len(factors)} settings of {preset}", element("p", _METHOD), *parts)


def _best_draws(factors: Sequence[Factor], groups: Sequence[Group], metric: Metric) -> Markup:
    """The draws that came out highest, with their settings, and how much of that is luck."""
    sign = -1 if metric.kind == "length" else 1
    means = [_mean(group.values(metric.column)) for group in groups]
    order = sorted(
        (place for place, mean in enumerate(means) if math.isfinite(mean)),
        key=lambda place: -sign * means[place],
    )
    rows = [
        (
            groups[place].label,
            shown_estimate(estimates.mean(groups[place].values(metric.column), bootstrap_rng())),
            len(groups[place].runs),
            *(grouped(factor.column[place]) for factor in factors),
        )
        for place in order[:_MOST_DRAWS]
    ]
    extreme = "lowest" if sign < 0 else "highest"
    header = ("draw", f"{metric.label} [95 %]", "n", *(factor.axle.label for factor in factors))
    summary = f"The {len(rows)} draws of {len(groups)} with the {extreme} {metric.title}"
    values = [_signed(group.by_seed(metric.column), sign) for group in groups]
    unseen = highest_unseen({(place,): of_draw for place, of_draw in enumerate(values)})
    luck = f"The {extreme} of many is so in part by luck."
    if math.isfinite(unseen):
        luck += (
            " Chosen by all seeds but one, and measured by the one left out, it has"
            f" {shown_number(sign * unseen)}."
        )
    return details(summary, joined([element("p", luck), table(header, rows)]))


def _signed(values: Values, sign: int) -> Values:
    return {seed: sign * value for seed, value in values.items()}


def _mean(values: Sequence[float]) -> float:
    there = [value for value in values if math.isfinite(value)]
    return sum(there) / len(there) if there else math.nan


# --- What settings do, in pictures and in words --------------------------------------------------


def _trends(page: Page, name: str, preset: str, found: Analysis, metric: Metric) -> Markup:
    """What settings do one by one."""
    small = page.small_print(
        f"{preset}. Dots: n = {len(found.values)} draws, each the mean of its runs. Line: what the"
        " setting does by itself, the others at their average; shaded: 95 % bootstrap interval"
        " over draws."
    )
    drawing = drawn(f"trends_{name}", Trends(metric.label, found), small)
    caption = f"{metric.label} of {preset}: what each setting does by itself"
    return page.picture(f"trends_{name}", caption, drawing)


def _shares(
    page: Page, name: str, preset: str, found: Analysis, metric: Metric, variants: str
) -> Markup:
    """How much settings and their pairs account for."""
    n_pairs = len(found.factors) * (len(found.factors) - 1) // 2
    hatched = " Hatched: too few variants." if len(found.together) < n_pairs else ""
    small = page.small_print(
        f"{preset}. Share of the variance of {metric.title} between n = {len(found.values)}"
        f" {variants}. Framed: of each setting by itself; below: of each pair beyond that, the"
        f" column's setting with the row's. Bold: more than chance.{hatched}"
    )
    drawing = drawn(f"shares_{name}", Shares(metric.title, found), small)
    caption = f"{metric.title} of {preset}: how much each setting and each pair accounts for"
    return page.picture(f"shares_{name}", caption, drawing)


def in_words(found: Analysis, title: str, variants: str) -> str:
    """Which settings matter and which do not, in sentences.

    Args:
        found: what they do.
        title: of the number that it is about.
        variants: what the variants are called.
    """
    names = [factor.axle.label for factor in found.factors]
    order = sorted(range(len(names)), key=lambda place: -found.alone[place].of_variance)
    telling = [place for place in order if found.alone[place].is_significant]
    others = [names[place] for place in order if place not in telling]
    low, high = float(found.values.min()), float(found.values.max())
    text = [
        f"Over {len(found.values)} {variants} {title} runs from {shown_number(low)} to"
        f" {shown_number(high)}. Settings"
        f" one by one account for {_per_cent(found.of_sum)} of that variance."
    ]
    if telling:
        shares = [f"{names[k]} ({_per_cent(found.alone[k].of_variance)})" for k in telling]
        verb = "matters" if len(shares) == 1 else "matter"
        text.append(f"By itself {verb}: {_listed(shares)}.")
    if others:
        text.append(f"No effect by itself can be seen of: {_listed(others)}.")
    pairs = sorted(found.together.items(), key=lambda item: -item[1].of_variance)
    beyond = [
        f"{names[i]} with {names[j]} ({_per_cent(share.of_variance)})"
        for (i, j), share in pairs
        if share.is_significant
    ]
    if beyond:
        text.append(f"Beyond that, some matter together: {_listed(beyond)}.")
    elif pairs:
        text.append("No pair of them can be seen to matter beyond that.")
    return " ".join(text)


def _per_cent(share: float) -> str:
    return "nothing" if share < _LEAST_SHARE else f"{100 * share:.0f} %"


def _listed(names: Sequence[str]) -> str:
    *first, last = names
    return f"{'; '.join(first)}; and {last}" if first else last


# --- All combinations ----------------------------------------------------------------------------


def _combinations_section(
    page: Page,
    number: int,
    preset: str,
    design: Design,
    groups: Sequence[Group],
    shown: Shown,
) -> None:
    parts: list[Markup] = []
    texts: list[str] = []
    for metric in swept_metrics(groups, shown):
        page.tell(f"looking at what was swept: {metric.title}")
        values = [group.by_seed(metric.column) for group in groups]
        found = [
            [_mean_over([values[k] for k in places]) for places in having]
            for having in design.having
        ]
        of_settings = [
            Effect(axle, [contrast.estimate for contrast in contrasts])
            for axle, contrasts in zip(design.axles, found, strict=True)
        ]
        text = _points_text(design, [contrast for contrasts in found for contrast in contrasts])
        texts.append(text)
        name = f"settings_{number}_{metric.column}"
        chart = Effects(metric.label, of_settings)
        drawing = drawn(name, chart, page.small_print(f"{preset}. {text}"))
        caption = f"{metric.label} of {preset} at each value of each setting"
        parts.append(page.picture(name, caption, drawing))
        rows = [
            (axle.label, grouped(value), shown_estimate(estimate), estimate.n, len(places))
            for (axle, found_at), having in zip(of_settings, design.having, strict=True)
            for value, estimate, places in zip(axle.values, found_at, having, strict=True)
        ]
        header = ("setting", "value", f"{metric.label} [95 %]", "n", "variants")
        parts.append(details("The intervals", table(header, rows)))
        parts += _shares_of(page, number, preset, groups, metric)
    # Small print is part of a picture, where it can be neither searched nor read aloud.
    said = [element("p", text) for text in dict.fromkeys(texts)]
    page.say(f"Each setting of {preset}", *said, *parts)


def _shares_of(
    page: Page, number: int, preset: str, groups: Sequence[Group], metric: Metric
) -> list[Markup]:
    """How much settings account for; nothing where there are too few variants to tell."""
    factors = effects.factors_of([group.overrides for group in groups], _settings(groups))
    found = effects.analysed(factors, [_mean(group.values(metric.column)) for group in groups])
    if found is None:
        return []
    name = f"{number}_{metric.column}"
    return [
        element("p", f"{in_words(found, metric.title, 'variants')} {_METHOD}"),
        _shares(page, name, preset, found, metric, "variants"),
    ]


def _mean_over(values: Sequence[Values]) -> Contrast:
    """Mean over variants of equal weight, by seed where they share seeds."""
    return estimates.contrast([(1 / len(values), by_seed) for by_seed in values], bootstrap_rng())


def _points_text(design: Design, found: Sequence[Contrast]) -> str:
    """What the points and bars of the settings are, as far as it is true of these."""
    n = counts(contrast.estimate for contrast in found)
    notes = ["Mean over all variants that have a value of a setting, whatever their others."]
    if all(contrast.paired for contrast in found):
        notes += [
            f"Bars: 95 % bootstrap interval over n = {n} seeds, each averaged over the variants"
            " first. As points share seeds, two may well differ though their bars overlap."
        ]
    elif any(contrast.estimate.n > 1 for contrast in found):
        notes += [f"Bars: 95 % bootstrap interval over n = {n} runs of each variant."]
    else:
        notes += [NO_INTERVAL]
    if not design.is_whole:
        notes += [
            "Not all combinations of the values are there, so two points may differ by what else"
            " differs between their variants."
        ]
    return " ".join(notes)
