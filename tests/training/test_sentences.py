"""Laws: the same corpus again and after a kill; each of its answers is of a clip that is there."""

import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.query.lines import read
from geotlm_lm.training import sentences
from geotlm_lm.training.sentences import (
    UNTOLD_SHARE,
    felt_words,
    read_sentences,
    write_sentences,
)
from geotlm_lm.training.truth import UNASKED

PER_CLIP = 12


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch):
    monkeypatch.setattr(sentences, "PART_CLIPS", 1)


@pytest.fixture(scope="module")
def written(answerer, tmp_path_factory):
    """The folder of a corpus of two clips, a part each."""
    folder = tmp_path_factory.mktemp("sentences")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sentences, "PART_CLIPS", 1)
        write_sentences(folder, None, clips=2, per_clip=PER_CLIP, seed=6)
    return folder


def test_a_missing_part_is_written_again_byte_for_byte(written):
    parts = sorted(written.glob("part_*.npz"))
    before = [part.read_bytes() for part in parts]
    parts[1].unlink()
    write_sentences(written, None, clips=2, per_clip=PER_CLIP, seed=6)
    assert [part.read_bytes() for part in parts] == before


@pytest.mark.slow  # starts processes
def test_the_corpus_does_not_depend_on_the_number_of_workers(written, tmp_path):
    write_sentences(tmp_path, None, clips=2, per_clip=PER_CLIP, seed=6, workers=2)
    for part in written.glob("part_*.npz"):
        assert (tmp_path / part.name).read_bytes() == part.read_bytes()


def test_a_folder_of_another_corpus_is_refused(written):
    with pytest.raises(UsageError, match="holds a run of another"):
        write_sentences(written, None, clips=2, per_clip=PER_CLIP, seed=7)


def test_rows_are_about_clips_that_are_there(written, answerer):
    corpus = read_sentences(written)
    clips = len(corpus.labels)
    assert corpus.numbers.shape[0] == corpus.words.shape[0] == clips
    assert np.isfinite(corpus.numbers).all()
    assert np.array_equal(corpus.words, felt_words(corpus.labels))
    assert 0 < len(corpus.rows) <= corpus.asked <= PER_CLIP * clips
    assert {row.clip for row in corpus.rows} == set(range(clips))
    # Of parts of one clip, each may be one row over.
    untold = sum(not row.is_told for row in corpus.rows)
    assert untold <= UNTOLD_SHARE * len(corpus.rows) + clips
    for row in corpus.rows:
        assert row.text
        assert row.sentence
        words = {each.word for asked in read(row.query).answers for each in asked}
        assert not words & sentences.NEVER


def test_what_is_felt_is_the_truth_of_each_component():
    turning = MotionLabel(
        Motion.CLOCKWISE,
        rotation_deg=12.0,
        depth_change_mm=0.03,  # neither pressed nor held
        contact_fraction=(0.1,) * 4,
        travel_px=(0.0, 0.0),
        radius_px=20.0,
    )
    nothing = MotionLabel(Motion.NONE, contact_fraction=(0.0,) * 4)
    assert felt_words([turning, nothing]).tolist() == [[0, 4, UNASKED, 0], [2, 4, 2, 1]]
