"""What the card counts: a scripted speaker whose right and wrong answers are known."""

import numpy as np
import pytest
import torch
from geotlm_lm.odometry.movement import MOVEMENT_DIM

from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.training.scoring import ClipSet, score_bundle, true_option_likelihoods
from tests.tiny_bundle import WIDTH, tiny_bundle

MOTIONS = (*DIRECTED, Motion.STILL, Motion.NONE)


class Knowing:
    """Reads the motion off the token and says one fixed thing of it."""

    def __init__(self, grammar, says):
        self.says = {one: grammar.sentence(says(one)) for one in Motion}

    def generate(self, tokens, questions):
        assert len(tokens) == len(questions)
        return [self.says[list(Motion)[int(token[0])]] for token in tokens]

    def score(self, token, question, options):
        said = self.says[list(Motion)[int(token[0])]]
        return np.array([0.0 if option == said else -5.0 for option in options])


def clips(contact_share=0.5, unreadable=0):
    labels = [MotionLabel(one, is_readable=i >= unreadable) for i, one in enumerate(MOTIONS)]
    tokens = torch.zeros(len(labels), WIDTH)
    tokens[:, 0] = torch.tensor([float(list(Motion).index(one)) for one in MOTIONS])
    share = np.full(len(labels), contact_share)
    moved = torch.zeros(len(labels), MOVEMENT_DIM)
    return ClipSet(tokens, tokens, share, moved, labels, ["ball"] * len(labels))


@pytest.fixture(scope="module")
def bundle():
    return tiny_bundle(Calibration(contact_threshold=0.1))


def truth_of(motion):
    return questions_for(MotionLabel(motion), np.random.default_rng(0), types=("T1",))[0].slots


def saying(bundle, says):
    bundle.speaker = Knowing(bundle.grammar, says)
    return bundle


def test_true_answers_are_all_right_and_claim_nothing_false(bundle):
    scores = score_bundle(saying(bundle, truth_of), clips(), seed=0)
    assert scores["rotation"]["generated"] == scores["sliding"]["generated"] == 1.0
    assert scores["sliding"]["generated_held_out_wordings"] == 1.0
    assert (scores["by_type"]["T1 seen"], scores["by_type"]["T1 held_out"]) == (1.0, 1.0)
    assert scores["false_directions"] == 0.0
    # The true one of ten answers is e^5 times as likely as each other one.
    assert scores["scored"] == 1.0
    assert scores["calibration_error"] == pytest.approx(9 / (np.e**5 + 9))
    # The sentence about direction answers no question of another kind.
    assert scores["by_type"]["T5 seen"] == 0.0


def test_a_direction_claimed_of_everything_is_counted(bundle):
    scores = score_bundle(saying(bundle, lambda _: truth_of(Motion.LEFT)), clips(), seed=0)
    assert scores["rotation"]["generated"] == 0.0
    assert scores["sliding"]["generated"] == 0.25
    assert scores["false_directions"] == 1.0


def test_directions_withheld_for_want_of_contact_are_neither_right_nor_claimed(bundle):
    untouched = clips(contact_share=0.05)
    scores = score_bundle(saying(bundle, truth_of), untouched, seed=0)
    assert scores["rotation"]["generated"] == scores["sliding"]["generated"] == 0.0
    # Still and untouched are no directions: they are said all the same, 2 of 8 clips.
    assert scores["by_type"]["T1 seen"] == 0.25
    claims = score_bundle(saying(bundle, lambda _: truth_of(Motion.LEFT)), untouched, seed=0)
    assert claims["false_directions"] == 0.0


def test_unreadable_clips_are_left_out_and_counted(bundle):
    scores = score_bundle(saying(bundle, truth_of), clips(unreadable=2), seed=0)
    assert (scores["clips"], scores["unreadable_clips"]) == (8, 2)
    assert scores["rotation"]["clips"] == 0
    assert scores["sliding"]["clips"] == 4


def test_calibration_reads_the_likelihood_of_the_true_answer(bundle):
    likelihoods, truths = true_option_likelihoods(saying(bundle, truth_of), clips(), seed=0)
    assert likelihoods.shape == (len(MOTIONS), len(Motion))
    assert (likelihoods[np.arange(len(truths)), truths] == 0.0).all()
