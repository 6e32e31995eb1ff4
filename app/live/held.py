"""A run as a session holds it: where it is to end, whether it goes on, and whether it is a copy."""

from dataclasses import dataclass, replace

from learners.commands import CommandError
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import MAX_TRIALS


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
    opened: Opened | None = None
    """Of which run of an experiment it is a copy, until something else is done with it."""

    def __post_init__(self) -> None:
        self.is_own = self.opened is None
        """Whether it began in its session, and was not made again from results."""

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

    def play(self) -> None:
        """Go on.

        Raises:
            CommandError: its trials are over, or it has stopped.
        """
        if self.error is not None:
            raise CommandError(f"the learner has stopped: {self.error}")
        self._check_not_over()
        self.playing = True

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
        self.playing = False
        if self.is_made_again:
            self.claim_no_more()

    def step_by_hand(self, max_steps: int = 2**62, trials: int | None = None) -> None:
        """Stand still after so many steps, or at the start of so many trials from here.

        Raises:
            CommandError: its trials are over, or it has stopped.
        """
        self._check_not_over()
        self.playing = False
        self._advance(max_steps, None if trials is None else self.run.trial + trials)
        self.claim_no_more()

    def go_on(self, steps: int) -> int:
        """Make steps, but not past where the run ended that it copies; returns how many."""
        opened = self.opened
        if opened is None or not self.is_made_again:
            self.opened = None
            return self._advance(steps)
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
            self.until_trial = max(self.run.spec.trials, self.run.trial)
            self.playing = self.playing and not self.is_over
        self.opened = None

    def _check_not_over(self) -> None:
        if self.run.trial >= MAX_TRIALS:
            raise CommandError(f"a run ends after {MAX_TRIALS:,} trials")
        if self.is_over:
            raise CommandError(
                f"the {self.until_trial:,} trials are over; under Run it can go on for more, or"
                " start again"
            )

    def _advance(self, max_steps: int, until_trial: int | None = None) -> int:
        if self.error is not None:
            raise CommandError(f"the learner has stopped: {self.error}")
        limit = self.until_trial if until_trial is None else until_trial
        made = self.run.advance(max_steps=max_steps, until_trial=limit)
        if self.is_over:
            self.playing = False
        return made
