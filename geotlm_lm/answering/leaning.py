"""Which way it goes if it goes at all: told where a question takes for granted what is denied.

Who asks "Which way is the cap turning?" of a turn that begins under a press is told of the press;
the model has an opinion on the turn all the same. Measured on 1,344 real windows of turns asked so,
of which 125 are told as something else: 61 lean, 60 of them the true way. Of 374 real and semi-real
slides 22 are told as something else; 7 lean, 6 of them the true way.
"""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import Answer, Encoded, Lean
from geotlm_lm.answering.withholding import LIKELIER, NEXT_LIKELIEST, UNRECOGNISED
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.claims import presumed_class
from geotlm_lm.conversation.wording import clause
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionClass

LEAST_SHARE = 0.7
"""Share, among the motions of the presumed kind, of one that is worth telling."""

LEAST_TOTAL = 0.02
"""Probability that these motions hold together; of less, 5 more windows lean, 4 rightly."""

KINDS = frozenset(("direction", "viewpoint"))
"""Kinds of questions about which way the object goes, as the clip shows it."""

_AMONG = {
    MotionClass.ROTATION: (ROTATIONS, "turns", "two turns"),
    MotionClass.SLIDE: (SLIDES, "slides", "four slides"),
}


def with_lean(bundle: Bundle, encoded: Encoded, question: str, answer: Answer) -> Answer:
    """Return the answer, with what it leans to where it denies the motion that is asked after.

    Nothing leans where next to nothing touches.
    """
    presumed = presumed_class(question)
    if answer.kind not in KINDS or presumed is None or not answer.options:
        return answer
    among, does, of_how_many = _AMONG[presumed]
    told = answer.direction or Motion(max(answer.options, key=answer.options.get))
    if told in (*among, Motion.NONE) or answer.text == UNRECOGNISED:
        return answer
    shares = {motion: answer.options.get(motion.value, 0.0) for motion in among}
    way, total = max(shares, key=shares.get), sum(shares.values())
    if total < LEAST_TOTAL or shares[way] < LEAST_SHARE * total:
        return answer
    if bundle.calibration.withholds(way, encoded.contact_share):
        return answer
    share = shares[way] / total
    text = f"If it {does} at all, {clause(way, answer.frame)}: {share:.0%} among the {of_how_many}."
    said = f": {way.value}."  # in a note on another answer, which would say it twice
    begins = (NEXT_LIKELIEST, LIKELIER)
    notes = [n for n in answer.notes if not (n.startswith(begins) and n.endswith(said))]
    return replace(answer, lean=Lean(way, share, text), notes=(*notes, text))
