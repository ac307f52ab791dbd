"""Decide whether an answer is given or withheld, for want of contact, reference or certainty."""

from __future__ import annotations

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query.decision import Decision
from geotlm_lm.recordings.idle import CONTACT_UNKNOWN

UNRECOGNISED = (
    "I cannot tell: the gel has changed by more than noise, but I recognise no touch in it; press "
    "harder, or record the idle gel again."
)
"""Said in place of a claim that nothing touches."""

NOTHING_CHANGES = (
    "Nothing moves in these frames; whether anything touches the gel I cannot tell without an idle "
    "frame: begin a recording before the touch, or give one as its background."
)
"""Said in place of "it is still" and "nothing touches" where the idle gel is a guess. Of 111 idle
starts of real recordings without their idle frame 96 were told as a still touch, 79 of them at 0.9
or more, and 106 as touching."""

OF_CONTACT = frozenset({"touch", "none", "press", "in", "out", "made", "lost"})
"""Atoms that say whether, or how deep, something touches."""

LEAST_SURE = 0.5
"""Probability below which an answer is withheld: it would more likely be wrong than right."""

_OF_MOTION = ("way", "kind", "claim", "choice", "amount", "place", "compare", "which-clip")
"""Asks whose answers are withheld; what else is asked is told whatever its probability."""


_OF_NO_PICTURE = ("recording", "setup", "again", "help", "talk", "unanswerable", "not-understood")
"""Asks that are answered of any picture, be it a gel's or not."""


def why_withheld(bundle: Bundle, encoded: Encoded, decision: Decision) -> str | None:
    """Return what is said in place of a decision; None where it is told, or told as a guess."""
    kind = decision.part.ask.kind
    if encoded.suspicion and kind not in _OF_NO_PICTURE:
        return f"I cannot tell. {encoded.suspicion}"
    if decision.missing is not None:
        return None
    if not encoded.is_contact_known and _tells_contact(decision):
        return CONTACT_UNKNOWN
    if kind not in _OF_MOTION:
        return None
    ways = [one.way for one in decision.movements if one.way in DIRECTED]
    if encoded.track is None and any(
        bundle.calibration.withholds(way, encoded.contact_share) for way in ways
    ):
        return (
            f"I cannot name a direction: I see next to no contact "
            f"(mask {encoded.contact_share:.3f})."
        )
    if _lacks_reference(encoded, decision):
        return NOTHING_CHANGES
    return UNRECOGNISED if encoded.is_changed and _denies_contact(decision) else None


def tentative(text: str, sure: float) -> str:
    """Return a sentence as a guess, where its probability is too small."""
    return f"I cannot tell for sure, {sure:.0%}: {text}"


def _lacks_reference(encoded: Encoded, decision: Decision) -> bool:
    """Tell whether an answer judges contact without a reference image of the idle gel.

    Whether anything moves may be told all the same: nothing does.
    """
    atoms = _atoms(decision)
    is_lacking = encoded.is_static or not encoded.is_contact_known
    if not is_lacking or (atoms and atoms <= {"move", "starts", "stops"}):
        return False
    return decision.rest is not None or bool(atoms & {"touch", "none"})


def _tells_contact(decision: Decision) -> bool:
    """Tell whether an answer says that something touches or not, where, or that it presses."""
    ask = decision.part.ask
    # An option that is so is told whatever else was offered; that none is so denies them all.
    told = [ask.options[k] for k in decision.options] if decision.options else ask.options
    chosen = {one.atom for option in told for one in option.proposition.literals}
    atoms = _atoms(decision) | chosen | {ask.of, ask.then}
    moved = {one.component for one in decision.movements} | set(decision.denied)
    return ask.kind == "place" or Component.PRESS in moved or bool(atoms & OF_CONTACT)


def _denies_contact(decision: Decision) -> bool:
    is_plain = not decision.times  # a touch too short, or too seldom, is seen
    is_denied = is_plain and _atoms(decision) == {"touch"} and decision.verdict is False
    return decision.rest is Motion.NONE or is_denied


def _atoms(decision: Decision) -> set[str]:
    proposition = decision.part.ask.proposition
    return set() if proposition is None else {one.atom for one in proposition.literals}
