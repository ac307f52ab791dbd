"""What the card counts: a scripted language model whose right and wrong words are known."""

import numpy as np
import pytest
import torch

from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel
from geotlm_lm.language.size import SLOTS
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.motion.measured import CANDIDATES, Measured
from geotlm_lm.query.program import ATOM_OF
from geotlm_lm.query.speaker import TactilePrefix
from geotlm_lm.training.scoring import ClipSet, felt_likelihoods, felt_scores, score_bundle
from geotlm_lm.training.sentences import felt_words
from geotlm_lm.training.truth import UNASKED
from tests.tiny_bundle import WIDTH, tiny_bundle

MOTIONS = (*DIRECTED, Motion.STILL, Motion.NONE)


def clips(labels):
    tokens = torch.zeros(len(labels), WIDTH)
    tokens[:, 0] = torch.arange(len(labels))
    count = len(labels)
    return ClipSet(tokens, tokens, np.ones(count), still(count), labels)


def still(count):
    hints = len(tiny_bundle().motion.mean)
    paths, radius = torch.zeros(count, CANDIDATES, 3), torch.ones(count)
    hints, every = torch.zeros(count, hints), torch.ones(count, CANDIDATES, dtype=torch.bool)
    return Measured(paths, torch.ones_like(paths), every, torch.zeros(count), radius, hints)


class Feeling:
    """Fills a clip's slots as it is told, three to one, but of a silent reading with their last
    word."""

    def __init__(self, words, mean):
        self.words, self.mean = words, mean

    def prefix(self, numbers):
        clip, slots = int(numbers[0]), {}
        is_silent = (numbers[-BELIEF_NUMBERS:] == self.mean[-BELIEF_NUMBERS:]).all()
        for place, (slot, among) in enumerate(SLOTS.items()):
            shares = np.full(len(among), 1.0)
            shares[-1 if is_silent else self.words[clip, place]] = 3.0
            slots[slot] = np.log(shares / shares.sum())
        return TactilePrefix(None, slots)


def feeling(words):
    bundle = tiny_bundle()
    bundle.speaker = Feeling(np.asarray(words), bundle.reader.decoder.projector["mean"])
    return bundle


def words_of(motion):
    """Places of the words that a motion has at the slots."""
    word = ATOM_OF.get(motion, "none")
    return [words.index(word) if word in words else len(words) - 1 for words in SLOTS.values()]


def test_the_words_at_the_slots_are_counted_among_the_motions_of_a_task():
    labels = [MotionLabel(one) for one in MOTIONS]
    words = np.array([words_of(one) for one in MOTIONS])
    right = score_bundle(feeling(words), clips(labels))
    assert right["rotation"]["language model's slots"] == 1.0
    assert right["sliding"]["language model's slots"] == 1.0
    left = words.copy()
    left[:, 1] = SLOTS["slide"].index("left")
    assert score_bundle(feeling(left), clips(labels))["sliding"]["language model's slots"] == 0.25


def test_unreadable_clips_are_left_out_and_counted():
    labels = [MotionLabel(one, is_readable=place >= 2) for place, one in enumerate(MOTIONS)]
    scores = score_bundle(feeling([words_of(one) for one in MOTIONS]), clips(labels))
    assert (scores["clips"], scores["unreadable_clips"]) == (8, 2)
    assert scores["rotation"]["clips"] == 0
    assert scores["sliding"]["clips"] == 4


MIXED = [
    MotionLabel(Motion.STILL, radius_px=20.0, visible_grey=(9.0,) * 3, **one)
    for one in (
        {"rotation_deg": 8.0, "travel_px": (-5.0, 1.0)},
        {"rotation_deg": -8.0, "depth_change_mm": 0.4},
        {"travel_px": (0.2, 0.0), "depth_change_mm": -0.4},
    )
]


def test_words_at_the_slots_are_scored_where_something_is_asked():
    count, seen = len(MIXED), clips(MIXED)
    words = felt_words(MIXED)
    assert (words == UNASKED).nonzero().tolist() == [[2, 1]]
    said = words.clamp(min=0)
    said[0, 0] = SLOTS["turn"].index("none")
    bundle = feeling(said)
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
