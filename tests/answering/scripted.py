"""A speaker and an odometer that say what a test wrote down, around a model of random weights."""

from types import SimpleNamespace

import numpy as np
import torch

from geotlm_lm.answering import OPEN_QUESTION, Answerer
from geotlm_lm.answering.model_query import AMOUNT_QUESTION, RATE_QUESTION
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.generation import ScoredAnswers
from geotlm_lm.language.parse_answer import AnswerGrammar, Slots
from geotlm_lm.odometry.odometer import AMOUNTS, amounts

FIRST_KINDS = ("direction", "verify", "choice", "class", "contact", "moving", "refusal")


class Scripted:
    """Says the sentence written for a question, else the one for any; remembers what it heard.

    An option is e^2.4 times as likely as each other one if it is what would be said, and e^2.3
    times if it is what the test says the model likes: more than half of the probability, of ten.
    """

    model = SimpleNamespace(state_dict=dict)  # no weights: a digest has nothing of it to hold

    def __init__(self, sentences):
        self.sentences = sentences
        self.likes = None
        self.heard = []

    def generate(self, fused_token, questions, listen=None):
        assert len(fused_token) == len(questions)
        self.heard += questions
        if listen is not None:
            (text,) = (self._says(question) for question in questions)
            for end in range(2, len(text) + 2, 2):  # two letters a token
                listen(text[:end])
        return [self._says(question) for question in questions]

    def weigh(self, fused_token, question, options):
        said = self._says(question)
        if said in options and question not in self.heard:
            self.heard.append(question)
        return ScoredAnswers(
            self.score(fused_token, question, options), said if said in options else None
        )

    def score(self, fused_token, question, options):
        said = self._says(question)
        return np.array(
            [-1.0 if one == said else -1.1 if one == self.likes else -3.4 for one in options]
        )

    def _says(self, question):
        return self.sentences.get(question, self.sentences.get("*"))


class Measuring:
    """An odometer that measures the same of every clip, sure of the amount nearest to it."""

    def __init__(self, **measures):
        self.measures = {"deg": 12.0, "px": 14.0} | measures

    def read(self, movement, unit):
        nearest = (amounts(unit) - self.measures[unit]).abs().argmin()
        return torch.eye(AMOUNTS)[nearest].expand(len(movement), -1)

    def state_dict(self):
        return {}


def first_kinds_of(grammar):
    """The grammar of a model that was trained on the first seven kinds alone."""
    sentences = [text for kind in FIRST_KINDS for text in grammar.options_for(kind)]
    return AnswerGrammar({text: grammar.parse(text) for text in sentences})


def answerer_saying(bundle, sentences, *, grammar=None, measures=None, **calibration):
    """An answerer whose model says `sentences`, by question; "*" stands for any."""
    grammar, odometer = grammar or bundle.grammar, Measuring(**measures or {})
    speaker, calibration = Scripted(sentences), Calibration(**calibration)
    return Answerer(type(bundle)(bundle.model, odometer, speaker, grammar, calibration, {}))


def feeling(bundle, motion, **calibration):
    """An answerer trained on the first kinds, which feels `motion` whatever it is asked."""
    grammar = first_kinds_of(bundle.grammar)
    said = grammar.sentence(Slots("direction", Motion(motion)))
    return answerer_saying(bundle, {"*": said, OPEN_QUESTION: said}, grammar=grammar, **calibration)


def measuring(bundle, motion, unit, **measures):
    """An answerer that tells `motion` when asked openly and measures an amount of `unit`."""
    said = {
        "*": bundle.grammar.sentence(Slots("direction", motion)),
        "how far?": (amount := bundle.grammar.sentence(Slots("magnitude", unit=unit))),
        AMOUNT_QUESTION: amount,
        RATE_QUESTION: bundle.grammar.sentence(Slots("rate", unit=unit)),
    }
    return answerer_saying(bundle, said, measures=measures, temperature=0.1)


def recording(frames=4, fps=None, seed=1, size=(48, 64)):
    rng = np.random.default_rng(seed)
    images = rng.integers(95, 120, (frames, *size, 3)).astype(np.uint8)
    return Clip(images, fps=fps, background=images[0], name="x.npy")
