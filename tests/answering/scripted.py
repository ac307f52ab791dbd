"""A reader and a belief that a test wrote down, around a model of random weights."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np

from geotlm_lm.answering import Answerer
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, WAYS, Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.copied import copied
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.reader import Reading


def believed(*ways, share=0.97, contact=None, deg=12.0, px=14.0, mm=0.5, spread=0.05):
    """A belief that these ways count, the larger first, and no other; a word of rest is none.

    The first goes so far, others 0.4 times; `spread` is the deviation, relative to each amount.
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

    def believing(self, encoded):
        super().believing(encoded)
        is_own = any(getattr(encoded.believe, "args", (None,))[0] is one for one in self.given)
        return encoded if is_own else self._scripted(encoded)

    def _scripted(self, encoded):
        self.given.append(self.belief)
        # A track would be asked in place of what is believed.
        return replace(encoded, track=None, believe=partial(_scripted, self.belief))


def _scripted(belief, encoded):
    return believed("none") if encoded.is_untouched else belief


class ScriptedReader:
    """Reads what a test wrote down, else takes the text itself for a program's line.

    Several lines with their chances are as many readings.
    """

    decoder = SimpleNamespace(stored={}, projector={})  # a digest has nothing of it to hold

    def __init__(self, lines=None, probability=0.98):
        self.lines, self.probability = {**READ, **(lines or {})}, probability
        self.heard = []

    def read(self, text):
        return self.readings(text)[0]

    def readings(self, text, most=5, sure=1.0, unlikely=frozenset()):
        self.heard.append(text)
        self.unlikely = unlikely
        lines = self.lines.get(text, text)
        lines = [(lines, self.probability)] if isinstance(lines, str) else lines
        numbers, texts = quantities(text), tuple(each.text for each in copied(text))
        return [Reading(line, numbers, texts, chance, chance) for line, chance in lines]

    def calibrated(self, chance):
        return chance


class Silent:
    """A language model that says nothing of a clip, or what a test lets it say."""

    def __init__(self, *texts):
        self.texts = texts

    def prefix(self, numbers):
        return SimpleNamespace(slots={})

    def sentence(self, felt, question, line, value):
        return ""

    def says(self, felt, question, line, text):
        return text in self.texts


READ = {
    "Which way?": "way all",
    "Which way is it going?": "way all",
    "Which way is it moving?": "way all",
    "Do they go the same way?": "same way all",
    "Which way is it turning?": "way turn",
    "Is it turning clockwise?": "cw",
    "How far?": "extent",
    "How far did it turn?": "amount turn",
    "How far did it slide?": "amount slide",
    "And mirrored?": "mirror again",
    "Are you sure?": "sure",
    "Why?": "why",
    "The image is mirrored.": "fact mirrored",
    "Is anything touching the gel?": "touch",
    "Is it moving?": "move",
    "What kind of motion is it?": "kind",
    "Do they turn the same way?": "same way turn",
    "Thanks!": "talk thanks",
}
"""What is read of the questions of tests; any other text is its own line."""


def feeling(bundle, *ways, belief=None, understood=0.98, **calibration):
    """An answerer that believes `ways`, and reads as tests write down."""
    reader = ScriptedReader(probability=understood)
    changed = replace(bundle, calibration=Calibration(**calibration))
    return Believing(read_by(changed, reader), belief or believed(*ways))


def read_by(bundle, reader):
    """A bundle whose questions another reads, and whose language model says nothing of a clip."""
    changed = replace(bundle, reader=reader)
    changed.speaker = Silent()
    return changed


def recording(frames=4, fps=None, seed=1, size=(48, 64)):
    rng = np.random.default_rng(seed)
    images = rng.integers(95, 120, (frames, *size, 3)).astype(np.uint8)
    return Clip(images, fps=fps, background=images[0], name="x.npy")
