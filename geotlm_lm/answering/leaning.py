"""Which way it goes if it goes at all: told where a question takes for granted what is denied.

Who asks "Which way is the cap turning?" of a turn that begins under a press is told of the press;
the model has an opinion on the turn all the same. Measured on 1,344 real windows of turns, of which
125 are told as something else: where one of the two turns holds 0.7 of what both have, in 66, it is
the true one in 0.97.
"""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import Answer, Encoded, Lean
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.claims import presumed_class
from geotlm_lm.conversation.wording import clause
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionClass

LEAST_SHARE = 0.7
"""Share, among the motions of the presumed kind, of one that is worth telling."""

KINDS = frozenset(("direction", "viewpoint", "actor", "mirrored", "reversed"))
"""Kinds of questions that are answered with a direction."""

_AMONG = {
    MotionClass.ROTATION: (ROTATIONS, "turns", "two turns"),
    MotionClass.SLIDE: (SLIDES, "slides", "four slides"),
}


def with_lean(bundle: Bundle, encoded: Encoded, question: str, answer: Answer) -> Answer:
    """Return the answer, with what it leans to where it denies the motion that is asked after.

    Nothing is added where next to nothing touches.
    """
    presumed = presumed_class(question)
    if answer.kind not in KINDS or presumed is None or not answer.options:
        return answer
    among, does, of_how_many = _AMONG[presumed]
    likeliest = Motion(max(answer.options, key=answer.options.get))
    if likeliest in (*among, Motion.NONE):
        return answer
    shares = {motion: answer.options.get(motion.value, 0.0) for motion in among}
    lean, total = max(shares, key=shares.get), sum(shares.values())
    if not total or shares[lean] < LEAST_SHARE * total:
        return answer
    if bundle.calibration.withholds(lean, encoded.contact_share):
        return answer
    share = shares[lean] / total
    note = (
        f"If it {does} at all, {clause(lean, answer.frame)}: {share:.0%} of what is left for the "
        f"{of_how_many}."
    )
    return replace(answer, lean=Lean(lean, share), notes=(*answer.notes, note))
