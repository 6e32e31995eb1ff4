"""A checkpoint is the run as it was; it takes little, and nobody changes it any more."""

from hypothesis import given
from hypothesis import strategies as st

from learners.checkpoints import logs_of
from learners.run import Run
from tests.support.lines import SEED, SPEC, Script, scripts, stands, tell

STEPS = 700


@given(script=scripts, later=st.integers(0, 3_000))
def test_a_run_that_is_restored_goes_on_as_the_run_did(script: Script, later: int) -> None:
    run = Run(SPEC, SEED)
    for steps, wish in script:
        run.advance(max_steps=steps)
        tell(run, wish)
    twin, checkpoint = run.copy(), run.checkpoint()
    assert (checkpoint.step, checkpoint.trial) == (run.step, run.trial)
    run.advance(max_steps=later)
    # What has ended since is in the logs, and is not the moment's.
    restored = Run.restored(checkpoint, logs_of(run.state))
    assert stands(restored) == stands(twin)
    restored.advance(max_steps=later)
    assert stands(restored) == stands(run)
    assert restored.world == run.world or SPEC.world != run.spec.world


def test_what_is_restored_is_independent() -> None:
    run = Run(SPEC, SEED)
    run.advance(max_steps=STEPS)
    checkpoint, before = run.checkpoint(), stands(run)
    for room in (0, 10, 10_000):
        restored = Run.restored(checkpoint, logs_of(run.state), room)
        assert restored.state.log_steps.size == max(room, run.trial)
        restored.advance(max_steps=STEPS)
        assert stands(restored) != before
    assert stands(run) == stands(Run.restored(checkpoint, logs_of(run.state))) == before


def test_a_checkpoint_takes_no_more_for_a_run_that_is_longer() -> None:
    run = Run(SPEC, SEED)
    first, events = run.checkpoint().nbytes, len(run.control.history)
    run.advance()
    more = len(run.control.history) - events
    assert run.checkpoint().nbytes == first + 8 * more
    tables = sum(getattr(run.state, name).nbytes for name in ("selection", "skills", "trail"))
    assert tables < first < 1.2 * tables
