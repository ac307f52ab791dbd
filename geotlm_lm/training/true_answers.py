"""Whether what is told of a simulated clip is so, by what was simulated.

The same program is evaluated on the truth as on what is believed, and the values are compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from geotlm_lm.answering.pipeline import Worded
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import WAYS, Component
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import Evidence
from geotlm_lm.query.program import Program, head_of
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Measure,
    Moved,
    Record,
    Recording,
    Remark,
    Truth,
    Value,
)
from geotlm_lm.query.worlds import worlds_of_clip
from geotlm_lm.query.written import decided, worded
from geotlm_lm.training.truth import component_truth

_EXACT = 1e-4
"""Variance of each component of what was simulated."""

OF_BELIEF = frozenset({"chance", "low", "high", "sigma", "margin", "limit"})
"""Words of programs for numbers that are the belief's own: no truth knows better."""

_PLAIN = frozenset({"sure", "sure-amount", "why", "extent", "alternatives"})
"""What is asked whose word holds more than the motion that it is about."""

_TELLER = Teller(Recording(rate_hz=1.0))


@dataclass(frozen=True)
class TrueAnswers:
    """What programs come to on the truth about a clip.

    Args:
        evidence: Of the clip, of which the truth is believed.
    """

    evidence: Evidence

    @classmethod
    def of(cls, evidence: Evidence, label: MotionLabel) -> TrueAnswers:
        """Return those of a clip, given what answers about it rest on and its label."""
        belief = true_belief(evidence.worlds.belief, label)
        return cls(replace(evidence, worlds=worlds_of_clip(belief)))

    def agree(self, answered: Worded, program: Program, frame: FrameSpec) -> bool:
        """Tell whether what a program was told to come to is true.

        It is if on the truth the same is told, or what differs is near enough.
        """
        true = answers(program, (self.evidence,), frame)
        pairs = zip(answered.values, true, strict=True)
        return all(is_true(*pair) or _same_text(answered, program.form, *pair) for pair in pairs)


def _same_text(answered: Worded, form: str, one: Value, other: Value) -> bool:
    texts = [worded([each], form, answered.teller, answered.sure).text for each in (one, other)]
    return texts[0] == texts[1]


def true_belief(belief: Belief, label: MotionLabel) -> Belief:
    """Return the belief of what a label says, as certain as can be.

    What moves too little to be graded, or unseen, moves if it is believed to; what can be seen, and
    from how far on, stays what is believed.
    """
    truth = component_truth(label)
    ways = dict.fromkeys(chain(*WAYS.values()), 0.0)
    for part, moves in truth.moves.items():
        if moves is None:
            moves = belief.moves(part) >= 0.5
        # Without the idle gel nothing is told of a press.
        if belief.is_contact_known or part is not Component.PRESS:
            ways[truth.twist.way(part)] = float(moves)
    return replace(
        belief,
        mean=truth.twist,
        covariance=_EXACT * np.eye(4),
        ways=ways,
        contact=float(truth.is_touched),
        radius_px=label.radius_px or belief.radius_px,
    )


def tells(value: Value) -> bool:
    """Tell whether a value says anything but that it cannot be told."""
    if isinstance(value, Record):
        return any(tells(each) for _, each in value.fields)
    return value.is_known


def is_true(answered: Value, true: Value) -> bool:
    """Tell whether a value is so, given what the same program comes to on the truth.

    Amounts are as near as a right answer's, a motion's ways are its own, and so is what is denied;
    that less is told than is so is no lie. What tells that it does not know is true.
    """
    if not answered.is_known:
        return True
    if type(answered) is not type(true):
        return False
    if isinstance(answered, Record) and isinstance(true, Record):
        return len(answered.fields) == len(true.fields) and all(
            is_true(one, other)
            for (_, one), (_, other) in zip(answered.fields, true.fields, strict=True)
        )
    if isinstance(answered, Remark) and isinstance(true, Remark):
        return (answered.kind, answered.topic) == (true.kind, true.topic)
    if not _goes(answered.moved, true.moved):
        return False
    if any(each.word in OF_BELIEF for each in answered.of):
        return True
    if isinstance(answered, Amount) and isinstance(true, Amount):
        return is_near(answered.amount, true.amount)
    if isinstance(answered, Truth) and isinstance(true, Truth):
        pairs = zip(answered.amounts, true.amounts, strict=False)
        if not all(is_near(one.amount, other.amount) for one, other in pairs):
            return False
    if (
        isinstance(answered, Choice)
        and isinstance(true, Choice)
        and answered.chosen[:1] != true.chosen[:1]
    ):
        return False
    if head_of(answered.of).word in _PLAIN:
        return True
    return decided(answered, _TELLER) == decided(true, _TELLER)


def is_near(answered: Measure, true: Measure) -> bool:
    """Tell whether an amount is within its tolerance, or a fifth of the true one."""
    far = max(
        answered.tolerance, true.tolerance, RELATIVE_TOLERANCE * abs(true.mean) * bool(true.unit)
    )
    return answered.unit == true.unit and abs(answered.mean - true.mean) <= far + 1e-9


def _goes(answered: Moved | None, true: Moved | None) -> bool:
    """Tell whether each motion that is told is one, and what is denied is none."""
    if answered is None or true is None:
        return True
    if (answered.rest, answered.still_axis) != (true.rest, true.still_axis):
        return False
    if not set(answered.denied) <= set(true.denied):
        return False
    own = {move.component: move for move in true.movements}
    for place, move in enumerate(answered.movements):
        other = own.get(move.component)
        if other is None or other.way is not move.way:
            return False
        if place == 0 and other is not true.movements[0]:
            return False
        if None not in (move.aslant, other.aslant) and move.aslant is not other.aslant:
            return False
        if None not in (move.amount, other.amount) and not is_near(move.amount, other.amount):
            return False
    return True
