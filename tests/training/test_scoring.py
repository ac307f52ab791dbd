"""What the card counts: a scripted speaker whose right and wrong answers are known."""

import numpy as np
import pytest
import torch

from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.language.slots import SLOTS
from geotlm_lm.motion.measured import CANDIDATES, Measured
from geotlm_lm.motion.network import BELIEF_NUMBERS
from geotlm_lm.training.language import UNASKED, felt_words
from geotlm_lm.training.scoring import (
    ClipSet,
    felt_likelihoods,
    felt_scores,
    score_bundle,
    true_option_likelihoods,
)
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
    return ClipSet(tokens, tokens, share, still(len(labels)), labels, ["ball"] * len(labels))


def still(count):
    hints = len(tiny_bundle().motion.mean)
    paths, radius = torch.zeros(count, CANDIDATES, 3), torch.ones(count)
    hints, every = torch.zeros(count, hints), torch.ones(count, CANDIDATES, dtype=torch.bool)
    return Measured(paths, torch.ones_like(paths), every, torch.zeros(count), radius, hints)


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


MIXED = [
    MotionLabel(Motion.STILL, radius_px=20.0, visible_grey=(9.0,) * 3, **one)
    for one in (
        {"rotation_deg": 8.0, "travel_px": (-5.0, 1.0)},
        {"rotation_deg": -8.0, "depth_change_mm": 0.4},
        {"travel_px": (0.2, 0.0), "depth_change_mm": -0.4},
    )
]


class Feeling:
    """Fills the slots as it is told, three to one, but of a silent reading with their last word."""

    def __init__(self, words, model):
        self.words, self.model = words, model

    def feel(self, readings):
        is_silent = (
            readings[:, -BELIEF_NUMBERS:] == self.model.projector.mean[-BELIEF_NUMBERS:]
        ).all()
        felt = {}
        for place, (slot, among) in enumerate(SLOTS.items()):
            said = torch.full((len(readings), len(among)), 1.0)
            chosen = [len(among) - 1] * len(readings) if is_silent else self.words[:, place]
            said[range(len(readings)), chosen] = 3.0
            felt[slot] = (said / said.sum(dim=1, keepdim=True)).log()
        return felt


def test_words_at_the_slots_are_scored_where_something_is_asked():
    bundle, count = tiny_bundle(), len(MIXED)
    tokens = torch.zeros(count, WIDTH)
    seen = ClipSet(tokens, tokens, np.ones(count), still(count), MIXED, ["ball"] * count)
    words = felt_words(MIXED)
    assert (words == UNASKED).nonzero().tolist() == [[2, 1]]
    said = words.clamp(min=0)
    said[0, 0] = SLOTS["turn"].index("none")
    bundle.speaker = Feeling(said, bundle.speaker.model)
    assert felt_scores(bundle, seen) == {
        "turn": pytest.approx(2 / 3),
        "slide": 1.0,
        "press": 1.0,
        "contact": 1.0,
    }
    # By the fused token alone everything is "none", and nothing is touched.
    silent = felt_scores(bundle, seen, is_silent=True)
    assert list(silent.values()) == pytest.approx([1 / 3, 1 / 2, 1 / 3, 0.0])
    likelihoods, truths = felt_likelihoods(bundle, seen)
    assert likelihoods.shape == (4 * count - 1, max(map(len, SLOTS.values())))
    assert np.exp(likelihoods).sum(axis=1) == pytest.approx(1.0)
    assert (likelihoods.argmax(axis=1) == truths).mean() == pytest.approx(10 / 11)
