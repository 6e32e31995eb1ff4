"""The schedule's panel in a real browser, on screens of several sizes."""

from tests.support.screen import Begin

IS_BETWEEN_THE_SIDE_PANELS = """() => {
    const side = edge => document.querySelector(`[data-dock-region=${edge}]`)
        .getBoundingClientRect();
    const panel = document.querySelector("[data-floating-window]:has(.pounce-planner)")
        .getBoundingClientRect();
    const left = panel.left - side("left").right;
    const right = side("right").left - panel.right;
    return left === 8 && right >= 6 && right <= 8 && panel.bottom <= window.innerHeight;
}"""


def test_the_schedule_takes_the_width_between_the_side_panels(begin: Begin) -> None:
    _, screen = begin()
    for width, height in [(1366, 768), (1920, 1080), (1440, 900)]:
        screen.page.set_viewport_size({"width": width, "height": height})
        screen.page.wait_for_function(IS_BETWEEN_THE_SIDE_PANELS)


def test_on_a_narrow_screen_the_schedule_lies_over_no_button_that_cannot_be_scrolled_to(
    begin: Begin,
) -> None:
    live, screen = begin(trial=10)
    former = live.session.status.snapshot.generation
    screen.page.set_viewport_size({"width": 1024, "height": 768})
    screen.button("Start again").click()
    status = live.wait_for(lambda status: status.snapshot.generation == former + 1)
    assert status.snapshot.trial == 0
