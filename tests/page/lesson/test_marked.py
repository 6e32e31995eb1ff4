"""Places and edges of regions, also where sensors are so coarse that a region has none."""

import pytest
import viser

from app.documents import presets
from app.documents.lesson_grammar import REGIONS
from app.lessons.regions import masks
from app.live.snapshot import take
from app.page.lesson.marked import cells_of, heading_known, place_in
from app.picture.outlines import region_lines
from learners.run import Run
from tests.support.lessons import Room, small_lesson, small_session
from tests.support.person import Person

COARSE = ["world.n_directions=8", "world.n_distances=3", "world.start_radius=[1, 2]"]
NOWHERE = """
title: Nowhere
minutes: 1
setup: {preset: timed, set: {world.n_distances: 3, world.start_radius: [1, 2]}}
steps:
  - {why: {inspect: far, text: "Nothing is far."}, look: {mark: far}}
  - {why: {inspect: behind, text: "Something is behind."}}
"""


@pytest.mark.parametrize("settings", [[], ["world.size=40"], COARSE])
def test_a_place_of_a_region_lies_in_it(settings: list[str]) -> None:
    run = Run(presets.load("timed", settings), 3)
    run.advance(max_steps=3_000)
    snapshot = take(run, "timed", 0)
    world = snapshot.spec.world
    for region in REGIONS:
        heading, there = heading_known(region, snapshot), masks(world)[region]
        place = place_in(region, snapshot, heading)
        edge = region_lines(there, world, heading, is_round=True)
        assert (place is None) == (not cells_of(region, world, heading).any())
        assert (len(edge) == 0) == (not there.any())
        if place is not None:
            assert cells_of(region, world, heading)[place[1], place[0]]
    assert any(not there.any() for there in masks(world).values()) == (settings == COARSE)


def test_a_card_about_a_region_without_places_shows_none(gui: viser.GuiApi, person: Person) -> None:
    room = Room(small_session(), gui, small_lesson(NOWHERE, "nowhere"))
    room.session.start()
    try:
        (sitter,) = room.sitters
        sitter.start("nowhere")
        assert sitter.card["kind"] == "why"
        assert (sitter.cell, sitter.lesson["inspect"]) == (None, None)
    finally:
        room.close()
