"""A cold answer that fails ends as the answer itself does."""

import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.experiments.cold_answer import AnswerFailed, cold_answer


def test_an_answer_that_fails_tells_its_sentence_and_exit_code(tmp_path):
    missing = tmp_path / "gone.npz"
    with pytest.raises(AnswerFailed) as failed:
        cold_answer(missing, "Which way?", command="report answer", runs=1)
    assert failed.value.exit_code == UnreadableClip.exit_code
    assert str(failed.value) == (
        f"the answer exited with 3: {missing}: no such file or folder; check the path."
    )
