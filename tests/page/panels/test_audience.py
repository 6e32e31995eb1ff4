"""What a presenter reads of those who look."""

from app.page.panels.audience import MOST_REWARDS, own_in_words
from app.player.presented import OwnLearners


def test_own_learners_are_said_in_numbers() -> None:
    assert own_in_words(OwnLearners(1, 0, ())) == ["1 own learner, 0 at work."]
    rewards = ((15_200, 64.4), (9_000, 12.0), (3_000, -3.6))
    assert own_in_words(OwnLearners(6, 2, rewards)) == [
        "6 own learners, 2 at work.",
        "Reward (at trial): 64 (15,200), 12 (9,000), \N{MINUS SIGN}4 (3,000).",
    ]


def test_of_a_large_class_the_best_are_said() -> None:
    rewards = tuple((1_000, float(100 - n)) for n in range(MOST_REWARDS + 4))
    _, said = own_in_words(OwnLearners(len(rewards), 0, rewards))
    assert said.endswith("71 (1,000), and 4 more.")
