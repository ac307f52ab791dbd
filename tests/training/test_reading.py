"""Questions are drawn alike however that is shared; a taught reader tells its teachers' mean."""

from itertools import islice

import pytest
import torch

from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.query.grammar import corpus
from geotlm_lm.query.reader import QuestionDecoder
from geotlm_lm.query.spelling import Spelling
from geotlm_lm.training import reading
from geotlm_lm.training.reading import LABEL, ReadingTraining, _loss, train_vocabulary
from geotlm_lm.training.reading_rows import POOL, Drawing, batch_of, rows_from

SIZE = LanguageSize(width=32, layers=1, heads=2, mlp=32, tactile_tokens=0, max_tokens=704)


@pytest.fixture(scope="module")
def drawing():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reading, "VOCABULARY_PAIRS", 200)
        tokenizer, lexicon = train_vocabulary(ReadingTraining(dropout=0, vocabulary=300), ())
    spelling = Spelling(tokenizer, lexicon=lexicon)
    return Drawing(spelling, corpus("train")[:20], 4, 0.25, SIZE.max_tokens, seed=5)


@pytest.mark.slow
def test_the_same_rows_come_from_any_step_on_and_by_any_number_of_processes(drawing):
    rows = list(islice(rows_from(drawing, 0, 0), 3 * POOL))
    assert sum(map(len, rows)) == pytest.approx(3 * POOL * 4, abs=3)
    assert list(islice(rows_from(drawing, POOL + 3, 0), POOL)) == rows[POOL + 3 : 2 * POOL + 3]
    assert list(islice(rows_from(drawing, 0, 2), 3 * POOL)) == rows


def test_each_text_is_hidden_by_its_own_share_and_no_query_is(drawing):
    (rows,) = islice(rows_from(drawing, 0, 0), 1)
    batch = batch_of(rows * 200, 0.2, torch.Generator().manual_seed(1), is_exchanged=True)
    changed = batch.shown != batch.ids
    is_shown = batch.is_seen & ~changed
    is_question = torch.arange(batch.ids.shape[1]) < torch.tensor([[s] for _, s in rows * 200])
    assert is_shown[batch.is_query].all()
    assert is_shown[is_question].float().mean() == pytest.approx(0.8, abs=0.03)
    assert batch.is_seen[changed].all()
    shares = 1 - (is_shown & is_question).sum(1) / is_question.sum(1)
    assert shares.min() == 0
    assert shares.max() > 0.3


def test_what_teachers_tell_together_is_learned_and_labels_of_what_is_hardly_hidden(drawing):
    (rows,) = islice(rows_from(drawing, 0, 0), 1)
    batch = batch_of(rows, 0.2, torch.Generator().manual_seed(1), is_exchanged=True)
    dark = batch._replace(is_light=torch.zeros_like(batch.is_light))
    light = batch._replace(is_light=torch.ones_like(batch.is_light))
    torch.manual_seed(3)
    one, other, pupil = (QuestionDecoder(SIZE, drawing.spelling.size) for _ in range(3))

    def cost(model, *teachers, shown=dark):
        return float(_loss(model, shown, teachers).detach())

    assert cost(one, one) < cost(pupil, one)
    both = (cost(pupil, one) + cost(pupil, other)) / 2
    assert cost(pupil, one, other) == pytest.approx(both)
    assert cost(pupil, one, shown=light) == pytest.approx(cost(pupil, one) + LABEL * cost(pupil))
