"""A run as a session holds it: where it is to end, whether it goes on, and whether it is a copy."""

from dataclasses import dataclass, replace

from learners.commands import CommandError, Introduce
from learners.control import is_still_wanted
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run


@dataclass(frozen=True)
class Opened:
    """A run of an experiment, made again."""

    name: str
    step: int
    """Where it ended."""
    digest: str
    """Of its tables there, as the results have it."""
    same: bool | None
    """Whether the tables made here have that digest; None while they are being made."""
    found: str = ""
    """The digest of the tables made here, once they are."""


@dataclass
class Held:
    """A run, and what is known of it besides. Only the worker's thread has to do with it."""

    run: Run
    generation: int
    """Its number among all runs that its session has had."""
    preset: str
    """As shown."""
    until_trial: int
    """Where it stands still by itself."""
    playing: bool
    error: str | None = None
    """What stopped it; its state is kept."""
    runs_to: int | None = None
    """Trial at whose start it is to stand still, on its way there at full speed."""
    opened: Opened | None = None
    """Of which run of an experiment it is a copy, until something else is done with it."""

    @property
    def is_begun(self) -> bool:
        """Whether a step has been made, or something been done by hand."""
        return self.run.step > 0 or bool(self.run.journal)

    @property
    def is_learning(self) -> bool:
        """Whether it goes on by itself."""
        return self.playing and self.error is None and not self.is_over

    @property
    def is_over(self) -> bool:
        """Whether it has had the trials that it was to have."""
        return self.run.trial >= self.until_trial

    @property
    def is_made_again(self) -> bool:
        """Whether it is on the way to where a run of an experiment ended."""
        return self.opened is not None and self.opened.same is None

    @property
    def own_end(self) -> int:
        """The trial at which it is to stand still once it is a run like any other."""
        if self.is_made_again:
            return max(self.run.spec.trials, self.run.trial)
        return self.until_trial

    @property
    def hurries(self) -> bool:
        """Whether it goes as fast as it can: the set speed is for watching, not for catching up."""
        return self.is_made_again or self.runs_to is not None

    def play(self) -> None:
        """Go on.

        Raises:
            CommandError: its trials are over, or it has stopped.
        """
        if self.error is not None:
            raise CommandError(f"the learner has stopped: {self.error}")
        self._check_not_over()
        self.playing, self.runs_to = True, None

    def run_to(self, trial: int) -> None:
        """Go on up to the start of a trial, and stand still there.

        Raises:
            CommandError: it has begun already, or is more than a run may have; or it has stopped.
        """
        if self.error is not None:
            raise CommandError(f"the learner has stopped: {self.error}")
        if trial > MAX_TRIALS:
            raise CommandError(f"a run ends after {MAX_TRIALS:,} trials")
        if trial <= self.run.trial:
            raise CommandError(
                f"trial {trial:,} has begun already, the learner is in trial {self.run.trial:,};"
                " the time bar shows what is past"
            )
        self.claim_no_more()
        self.until_trial = max(self.until_trial, trial)
        self.playing, self.runs_to = True, trial

    def take_more_trials(self) -> None:
        """Where its trials are over, let it have as many again as its preset has.

        Raises:
            CommandError: it has had all that a run may have, or it has stopped.
        """
        if self.error is not None:
            raise CommandError(f"the learner has stopped: {self.error}")
        if self.run.trial >= MAX_TRIALS:
            raise CommandError(f"a run ends after {MAX_TRIALS:,} trials")
        if self.is_over:
            self.until_trial = min(self.until_trial + self.run.spec.trials, MAX_TRIALS)

    def pause(self) -> None:
        """Stand still; a copy that is not complete is given up."""
        self.playing, self.runs_to = False, None
        if self.is_made_again:
            self.claim_no_more()

    def step_by_hand(self, max_steps: int = 2**62, trials: int | None = None) -> None:
        """Stand still after so many steps, or at the start of so many trials from here.

        Raises:
            CommandError: its trials are over, or it has stopped.
        """
        self._check_not_over()
        self.playing, self.runs_to = False, None
        self._advance(max_steps, None if trials is None else self.run.trial + trials)
        self.claim_no_more()

    def go_on(self, steps: int, pauses_at_joins: bool = False) -> int:
        """Make steps, but not past where it is to stand still; returns how many.

        That is where the run ended that it copies, the trial that it runs to or, if it
        ``pauses_at_joins``, the next one at which the schedule adds a skill, or a rule.
        """
        opened = self.opened
        if opened is None or not self.is_made_again:
            self.opened = None
            join = self._next_join() if pauses_at_joins else None
            stops = [stop for stop in (self.runs_to, join) if stop is not None]
            made = self._advance(steps, min([self.until_trial, *stops]), pauses_at_joins)
            is_there = bool(stops) and self.run.trial >= min(stops)
            if is_there or (pauses_at_joins and self.run.joins_by_rule):
                self.pause()
            return made
        made = self._advance(min(steps, opened.step - self.run.step))
        if self.run.step >= opened.step or self.is_over:
            found = digest(self.run.state)
            self.playing = False
            self.claim_no_more()
            self.opened = replace(opened, same=found == opened.digest, found=found)
        return made

    def claim_no_more(self) -> None:
        """From here on it is a run like any other, with the trials it was to have."""
        if self.is_made_again:
            self.until_trial = self.own_end
            self.playing = self.playing and not self.is_over
        self.opened = None

    def _next_join(self) -> int | None:
        """The next trial at which the schedule is to add a skill."""
        control, now = self.run.control, self.run.trial
        joins = (
            timer.trial
            for timer in self.run.planned()
            if isinstance(timer.command, Introduce) and is_still_wanted(control, timer.command)
        )
        return next((trial for trial in joins if trial > now), None)

    def _check_not_over(self) -> None:
        if self.run.trial >= MAX_TRIALS:
            raise CommandError(f"a run ends after {MAX_TRIALS:,} trials")
        if self.is_over:
            raise CommandError(
                f"the {self.until_trial:,} trials are over; under Run it can go on for more, or"
                " start again"
            )

    def _advance(
        self, max_steps: int, until_trial: int | None = None, stops_at_rules: bool = False
    ) -> int:
        if self.error is not None:
            raise CommandError(f"the learner has stopped: {self.error}")
        limit = self.until_trial if until_trial is None else until_trial
        made = self.run.advance(max_steps, limit, stops_at_rules)
        if self.is_over:
            self.playing, self.runs_to = False, None
        return made
