"""English, which has every phrase."""

from typing import Final

from app.lessons.phrases.language import Language

ENGLISH: Final = Language(
    thousands=",",
    grouped_from=1_000,
    point=".",
    percent="%",
    phrases={
        "and": "and",
        "trial": "trial {trial}",
        "runs.one": "{n} run",
        "runs.more": "{n} runs",
        "in_of.one": "in {k} of {n} run",
        "in_of.more": "in {k} of {n} runs",
        # Octants.
        "octant.e": "ahead",
        "octant.ne": "ahead left",
        "octant.n": "left flank",
        "octant.nw": "behind left",
        "octant.w": "behind",
        "octant.sw": "behind right",
        "octant.s": "right flank",
        "octant.se": "ahead right",
        # The board.
        "board.k_of_n": "{k} of {n}",
        "board.guess": "outlined: your guess",
        "board.numbers": "numbers: of {n} runs",
        "board.run": "blue: this run",
        "board.class": "orange: the class",
        # What the card waits for.
        "busy.other_run": "Another run is on the board than this lesson's.",
        "busy.before": (
            "This is the moment before. What you do here makes a branch, and the lesson goes on"
            " with that."
        ),
        "busy.start": (
            "It learns up to trial {start}, where this begins; it is in trial {trial} …"
        ),
        "busy.learns": "It learns on to trial {until}; it is in trial {trial} …",
        "busy.catches.one": "It goes on, one trial at a time, for {n} catch …",
        "busy.catches.more": "It goes on, one trial at a time, for {n} catches …",
        "busy.experiment": "The experiment begins …",
        "busy.experiment_runs.one": "{done} of {n} run are made …",
        "busy.experiment_runs.more": "{done} of {n} runs are made …",
        # What became of it.
        "check.done": "Done.",
        "check.yes": "Yes, in trial {trial}.",
        "check.never": "This can no longer come true in this run.",
        "check.not_yet": "Not yet.",
        "check.until": "Not yet. There is time until trial {until}.",
        "reveal.ahead": "What came of it is not known yet: the run has not come so far.",
        "reveal.other_run": "The board still shows the run from before.",
        "reveal.twenty": ("Twenty runs are made to compare this one with; {n} are there so far …"),
        "score.no_answer": "No run has an answer to this.",
        "score.key": "It is {what}.",
        "score.own": "In this run: {what}.",
        "score.own_never": "In this run it has not come.",
        "score.all": "Over all: {what}.",
        "score.range": "{low} to {high}",
        "score.always": "always",
        "score.spread": "{runs}: {what} ({range}).",
        "score.never.one": "In {k} of {n} run it never came.",
        "score.never.more": "In {k} of {n} runs it never came.",
        "score.octants": "Every direction that runs agree on is as you said.",
        "score.missed.one": "You left out {n} direction.",
        "score.missed.more": "You left out {n} directions.",
        "score.wrong.one": "{n} direction of yours stayed without.",
        "score.wrong.more": "{n} directions of yours stayed without.",
        "score.no_curve": "The curve is not known so far.",
        "score.point.one": "{k} of your {points} points lies within what {n} run did.",
        "score.point.more": "{k} of your {points} points lies within what {n} runs did.",
        "score.points.one": "{k} of your {points} points lie within what {n} run did.",
        "score.points.more": "{k} of your {points} points lie within what {n} runs did.",
        "score.no_pairs": "Runs do not agree on any two of these.",
        "score.pairs.one": "Of {n} pair that runs agree on, {k} are as you said.",
        "score.pairs.more": "Of {n} pairs that runs agree on, {k} are as you said.",
        "sure": "When you said {percent}\u00a0%, you were right in {k} of {n}.",
        # Controls.
        "control.play": "Play",
        "control.pause": "Pause",
        "control.over": "This run has had all its trials.",
        "control.run_to": "Run to trial {trial}",
        "control.runs_to": "On the way to trial {trial} …",
        "control.is_there": "That trial has come.",
        "control.on_its_way": "It is on its way.",
        "control.step": "One step",
        "control.trial": "One trial",
        "control.speed": "Speed",
        "control.speed_of": "{n} steps/s",
        "control.add_skill": "Add {skill} now",
        "control.explore": "Explore {skill}: {trials} trials at {chance}",
        "control.stop_exploring": "Stop exploring {skill}",
        "control.freeze_selection": "Freeze selection",
        "control.freeze_skills": "Freeze skills",
        "control.plan": "Follow schedule",
        "control.layer": "Layer",
        "control.headings": "Headings",
        "control.turned": "All as one, prey looks right",
        "control.all": "All headings, side by side",
        "control.as_in_trial": "As in the running trial",
        "control.side": "Runs side by side",
        "control.watch": "Watch a hunt",
        "control.experiment": "Run the experiment {name}",
        "control.undo": "Take back the last change",
        "control.nothing_done": "Nothing was done by hand yet.",
        "control.start_again": "Start this run again",
        "control.back_to_run": "Back to the lesson's run",
        # What is said of the lesson's file, and of what could not be done.
        "news.changed": (
            "This lesson's file has changed since you began it. You go on with the lesson as it"
            " was; from the beginning it is the new one."
        ),
        "news.gone": (
            "This lesson's file is not there any more, or cannot be read. You go on with the lesson"
            " as it was when you began it."
        ),
        "fault.unreadable": "The lesson of this session cannot be read by this pounce.",
        "fault.no_lesson": "That lesson is not here any more",
        "fault.not_whole": "The file has not come whole; choose it again",
        "fault.no_answer": "Your answer has not come here; give it again, and commit it then",
        "fault.too_large": "The file is too large; allowed: at most {n} bytes",
        "fault.added": "“{title}” is in the list now.",
        # The printed sheet.
        "sheet.say": "Read",
        "sheet.ask": "Predict",
        "sheet.do": "Do",
        "sheet.see": "What do you see?",
        "sheet.why": "Why?",
        "sheet.transfer": "And now?",
        "sheet.free": "Try it",
        "sheet.about": (
            "{minutes} minutes, beside the board; preset {preset}, seed {seed}, from trial {trial}."
        ),
        "sheet.own_words": "Explain it in your own words, before you go on.",
        "sheet.number_them": "Number them, 1 for the first.",
        "sheet.shade": ("The prey is in the middle and looks to the right. Shade the directions."),
        "sheet.mark": "Mark the trial.",
        "sheet.draw": "Draw the reward per trial (up) along the trials (to the right).",
        "sheet.sure": "How sure are you?",
        "sheet.board": (
            "The board at trial {trial}. Pale is near to a catch, dark is far from one; what is"
            " dotted is known only in part, and grey is not known."
        ),
        "sheet.answers": "Answers: {title}",
        "sheet.answers_of": (
            "From the lesson's own run, which has seed {seed}, and from {n} runs that differ by"
            " their seeds, so by luck alone. Nobody is wrong who is within what these do."
        ),
        "sheet.this_run": "This run",
        "sheet.in_runs": "In {k} of {n} runs",
        "sheet.from_to": "In {n} runs from {low} to {high}, half of them below {median}.",
        "sheet.octants": "In how many of {n} runs each direction is among them:",
        "sheet.band": (
            "The line is this run; the grey band lies between the lowest and the highest of {n}"
            " runs."
        ),
        "sheet.nothing": "none",
        "sheet.note": "For the teacher:",
    },
)
