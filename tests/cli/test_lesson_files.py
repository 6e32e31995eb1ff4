"""Files of lessons at the command line: one that cannot be taught is refused, in words, with 2."""

from pathlib import Path
from typing import Any

import pytest

from app.cli import main
from app.documents import lessons
from tests.support.hostile_lessons import mutation

pytestmark = pytest.mark.usefixtures("here")


@pytest.mark.parametrize("part", range(2))
def test_a_file_that_means_ill_begins_a_lesson_or_is_refused(
    here: Path, opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str], part: int
) -> None:
    texts = [file.read_bytes() for file in lessons.shipped().values()]
    path = here / "mine.yaml"
    codes: list[int] = []
    for seed in range(1_000 + 20 * part, 1_020 + 20 * part):
        path.write_bytes(mutation(texts[seed % len(texts)], seed))
        n_opened = len(opened)
        codes.append(main.main(["lab", "--lesson", "mine.yaml", "--no-journal"]))
        out, err = capsys.readouterr()
        assert out == ""
        assert "Traceback" not in err
        if codes[-1] == 0:
            assert opened[-1]["lesson"].name == "mine"
        else:
            assert (codes[-1], len(opened)) == (2, n_opened)
            assert err.startswith("mine.yaml")
            # Checked, it is refused in the same words.
            assert main.main(["lesson", "check", "mine.yaml"]) == 2
            assert capsys.readouterr() == ("", err)
    assert codes.count(2) > 10
