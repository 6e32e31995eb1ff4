"""How fast the learner is, and how well a browser follows it, in words."""

from app.live.status import Status
from app.server.pulse import Reading
from app.words.numbers import counted, speed_in_words


def clock_html(reading: Reading, status: Status, viewers: int) -> str:
    """The honest clock."""
    behind = f"{reading.behind_s:.1f} s behind" if reading.behind_s > 0.05 else "up to date"
    seeing = counted(viewers, "viewer")
    speed = speed_in_words(status.steps_per_s)
    speed = speed if status.behind is None else f"The live run: {speed}"
    return (
        '<div style="padding:0 0.7em;font-size:0.8em;line-height:1.5">'
        f"{speed}; {reading.drawing_share:.0%} of the time is spent on"
        f" drawing.<br>This browser: {reading.frame_rate:.1f} frames/s, {reading.frames_sent} sent"
        f" and {reading.frames_skipped} skipped in 5 s, {behind}."
        f"<br>{seeing} of this session.</div>"
    )
