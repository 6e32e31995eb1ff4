"""Reports on variants: what is set against what."""

import json
from pathlib import Path

from app.documents import presets
from tests.support.folders import add_run, new_folder
from tests.support.reports import page_of, table_of


def test_learners_of_the_thesis_stand_among_the_variants_of_their_experiment(
    tmp_path: Path,
) -> None:
    folder = new_folder(tmp_path / "variants", metrics=["final_reward"])
    own = presets.load("timed").model_dump(mode="json")
    own["learner"]["epsilon"] = 0.3
    written = json.dumps({**own, "overrides": {}})
    for seed in range(2):
        add_run(folder, seed, "standard_q", final_reward=20.0 + seed)
        add_run(folder, seed, "mine", settings=written, final_reward=60.0 + seed)
        add_run(folder, seed, "timed", final_reward=80.0 + seed)
        add_run(folder, seed, "other", settings=written, final_reward=61.0 + seed)
    rows = table_of(page_of(folder), "P(variant higher)")
    assert sorted(row["variant"] for row in rows) == ["mine", "other", "standard_q", "timed"]
