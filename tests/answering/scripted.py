"""A speaker and a belief that say what a test wrote down, around a model of random weights."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np

from geotlm_lm.answering import OPEN_QUESTION, Answerer
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, WAYS, Component, Twist
from geotlm_lm.language.parse_answer import AnswerGrammar, Slots
from geotlm_lm.motion.belief import Belief

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

    def would_write(self, fused_token, question, sentence):
        if question not in self.heard:
            self.heard.append(question)
        return self._says(question) == sentence

    def score(self, fused_token, question, options):
        said = self._says(question)
        return np.array(
            [-1.0 if one == said else -1.1 if one == self.likes else -3.4 for one in options]
        )

    def _says(self, question):
        return self.sentences.get(question, self.sentences.get("*"))


def believed(*ways, share=0.97, contact=None, deg=12.0, px=14.0, mm=0.5, spread=0.05):
    """A belief that these ways count, the larger first, and no other; a word of rest is none.

    Args:
        share: Probability of each, the rest being that it does not count.
        contact: Probability of contact; None makes it that of a touch, or of none for "none".
        deg: How far a turn goes; a lesser turn or slide beside another goes half as far.
        px: How far a slide goes, pixels of the 224-pixel image.
        mm: How deep a press goes.
        spread: Deviation of each amount, relative to it.
    """
    ways = [Motion(way) for way in ways]
    shares = {way: 0.0 for ways_ in WAYS.values() for way in ways_}
    parts = {"turn_deg": 0.0, "right_px": 0.0, "down_px": 0.0, "inward_mm": 0.0}
    for place, way in enumerate(one for one in ways if one in COMPONENT_OF):
        shares[way] = share
        half = 1.0 if place == 0 else 0.4
        far = {Component.TURN: deg, Component.SLIDE: px, Component.PRESS: mm}[COMPONENT_OF[way]]
        name, sign = _PART[way]
        parts[name] = sign * half * far
    spreads = [max(spread * abs(part), 1e-3) ** 2 for part in parts.values()]
    touching = contact if contact is not None else float(Motion.NONE not in ways)
    readable = dict.fromkeys(Component, True)
    return Belief(Twist(**parts), np.diag(spreads), shares, touching, 60.0, readable)


_PART = {
    Motion.CLOCKWISE: ("turn_deg", 1),
    Motion.COUNTERCLOCKWISE: ("turn_deg", -1),
    Motion.RIGHT: ("right_px", 1),
    Motion.LEFT: ("right_px", -1),
    Motion.DOWN: ("down_px", 1),
    Motion.UP: ("down_px", -1),
    Motion.PRESS: ("inward_mm", 1),
    Motion.RELEASE: ("inward_mm", -1),
}


class Believing(Answerer):
    """An answerer that believes the same of every clip that anything touches."""

    def __init__(self, bundle, belief):
        super().__init__(bundle)
        self.belief, self.given = belief, []

    def encode(self, clip, *, span=None):
        return self._scripted(super().encode(clip, span=span))

    def _believing(self, encoded):
        super()._believing(encoded)
        is_own = any(getattr(encoded.believe, "args", (None,))[0] is one for one in self.given)
        return encoded if is_own else self._scripted(encoded)

    def _scripted(self, encoded):
        self.given.append(self.belief)
        return replace(encoded, believe=partial(_scripted, self.belief))


def _scripted(belief, encoded):
    return believed("none") if encoded.is_untouched else belief


def first_kinds_of(grammar):
    """The grammar of a model that was trained on the first seven kinds alone."""
    sentences = [text for kind in FIRST_KINDS for text in grammar.options_for(kind)]
    return AnswerGrammar({text: grammar.parse(text) for text in sentences})


def answerer_saying(bundle, sentences, *, grammar=None, belief=None, **calibration):
    """An answerer whose model says `sentences`, by question; "*" stands for any.

    What it believes is the motion that it says when asked openly, where nothing else is given.
    """
    grammar = grammar or bundle.grammar
    if belief is None:
        opened = (grammar.parse(sentences.get(asked, "")) for asked in (OPEN_QUESTION, "*"))
        said = [one.direction for one in opened if one and one.direction]
        belief = believed(said[0] if said else Motion.LEFT)
    speaker, calibration = Scripted(sentences), Calibration(**calibration)
    changed = replace(bundle, speaker=speaker, grammar=grammar, calibration=calibration)
    return Believing(changed, belief)


def feeling(bundle, *ways, belief=None, **calibration):
    """An answerer trained on the first kinds, which says and feels `ways` whatever it is asked."""
    grammar = first_kinds_of(bundle.grammar)
    said = grammar.sentence(Slots("direction", Motion(ways[0])))
    belief = belief or believed(*ways)
    sentences = {"*": said, OPEN_QUESTION: said}
    return answerer_saying(bundle, sentences, grammar=grammar, belief=belief, **calibration)


def measuring(bundle, motion, **amounts):
    """An answerer that tells `motion` when asked openly and believes that it goes so far."""
    said = {"*": bundle.grammar.sentence(Slots("direction", Motion(motion)))}
    return answerer_saying(bundle, said, belief=believed(motion, **amounts))


def recording(frames=4, fps=None, seed=1, size=(48, 64)):
    rng = np.random.default_rng(seed)
    images = rng.integers(95, 120, (frames, *size, 3)).astype(np.uint8)
    return Clip(images, fps=fps, background=images[0], name="x.npy")
