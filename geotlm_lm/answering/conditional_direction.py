"""The most likely direction, given that the motion a question presumes occurs at all.

Who asks "Which way is the cap turning?" of a turn that begins under a press is told of the press;
the model has an opinion on the turn all the same, and so has the linear probe, which was taught to
tell motions apart and no words. Measured on 2,822 real windows and recordings of turns asked so,
of which 187 are told as something else: 120 lean by the opinion of both, 111 of them the true way
(by the language model's alone 99 and 94, by the probe's alone 128 and 118). Of 480 slides 39 are
told as something else; 17 lean, 15 of them the true way (9 and 7, 19 and 15). Of 107 real presses
12 lean to a turn (11, 13).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geotlm_lm.answering.abstention import LIKELIER, NEXT_LIKELIEST, UNRECOGNISED
from geotlm_lm.answering.answer import Answer, Encoded, Lean
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.motion_claims import presumed_class
from geotlm_lm.conversation.wording import direction_clause
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionClass

LEAST_SHARE = 0.7
"""Share, among the motions of the presumed kind, of one that is worth telling."""

LEAST_TOTAL = 0.02
"""Probability that these motions hold together in the language model's opinion. From half of it on
12 more windows lean to a turn, 10 rightly, but 11 more presses."""

LEAST = 1e-12
"""What a motion keeps of an opinion that gives it none: the other's then decides among the rest."""

KINDS = frozenset(("direction", "viewpoint"))
"""Kinds of questions about which way the object goes, as the clip shows it."""

_AMONG = {
    MotionClass.ROTATION: (ROTATIONS, "turns", "two turns"),
    MotionClass.SLIDE: (SLIDES, "slides", "four slides"),
}


def with_conditional_direction(
    bundle: Bundle, encoded: Encoded, question: str, answer: Answer
) -> Answer:
    """Return the answer; where it denies the presumed motion, with its conditional direction.

    Nothing leans where next to nothing touches.
    """
    presumed = presumed_class(question)
    if answer.kind not in KINDS or presumed is None or not answer.options:
        return answer
    among, does, of_how_many = _AMONG[presumed]
    told = answer.direction or Motion(max(answer.options, key=answer.options.get))
    if told in (*among, Motion.NONE) or answer.text == UNRECOGNISED:
        return answer
    if sum(answer.options.get(motion.value, 0.0) for motion in among) < LEAST_TOTAL:
        return answer
    shares = _shares(bundle, encoded, answer, among)
    way = max(shares, key=shares.get)
    if shares[way] < LEAST_SHARE:
        return answer
    if bundle.calibration.withholds(way, encoded.contact_share):
        return answer
    share = shares[way]
    clause = direction_clause(way, answer.frame)
    text = f"If it {does} at all, {clause}: {share:.0%} among the {of_how_many}."
    said = f": {way.value}."  # in a note on another answer, which would say it twice
    begins = (NEXT_LIKELIEST, LIKELIER)
    notes = [n for n in answer.notes if not (n.startswith(begins) and n.endswith(said))]
    return replace(answer, lean=Lean(way, share, text), notes=(*notes, text))


def _shares(
    bundle: Bundle, encoded: Encoded, answer: Answer, among: Sequence[Motion]
) -> dict[Motion, float]:
    """Return how probable each motion is if it is one of `among`, which are in the answer's frame.

    The geometric mean of what the language model and the linear probe hold.
    """
    said = np.array([answer.options.get(motion.value, 0.0) for motion in among])
    in_the_image = [answer.frame.in_the_image(motion) for motion in among]
    token = encoded.perception.fused_token
    read = bundle.model.probe.probabilities(token, in_the_image)[0].double().numpy()
    both = np.sqrt(said.clip(LEAST) * read.clip(LEAST))
    return dict(zip(among, (both / both.sum()).tolist(), strict=True))
