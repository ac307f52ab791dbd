"""From what a model said to an answer: its words where they are one, else by rule from them."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import (
    Answer,
    Encoded,
    deciding_word,
    evidence,
    offered_letters,
)
from geotlm_lm.answering.hearing import (
    AMOUNT_QUESTION,
    EVIDENCE_QUESTION,
    MOVING_QUESTION,
    OPEN_QUESTION,
    RATE_QUESTION,
    Heard,
    Overhear,
    hear,
    hear_likeliest,
    score,
)
from geotlm_lm.answering.measuring import answer_measured
from geotlm_lm.answering.withholding import plain, unless_withheld
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.beyond_touch import asks_beyond_touch
from geotlm_lm.conversation.claims import (
    claimed,
    claimed_motion,
    claims_end,
    claims_motion,
    motions_named,
    nearly_named,
    offered_options,
)
from geotlm_lm.conversation.kinds import (
    LATER_KINDS,
    asked_kind,
    asks_whether_moving,
    is_ruled_out,
)
from geotlm_lm.conversation.reasons import halves
from geotlm_lm.conversation.retell import (
    ALWAYS_RETOLD,
    CAMERA,
    RETOLD,
    Felt,
    Told,
    retell,
)
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots

NOT_UNDERSTOOD = "I found no words for that; ask how the touched object moves."
"""Said in place of words that are none of the answers: half-right words must not look like one."""

KNOWN_WORDS = {
    "magnitude": AMOUNT_QUESTION,
    "rate": RATE_QUESTION,
    "moving": MOVING_QUESTION,
    "evidence": EVIDENCE_QUESTION,
}
"""Kinds that no rule derives from a direction -> a question of theirs known from training."""

UNTRAINED = {
    "magnitude": "I cannot tell how far it moved: this model was not trained for amounts.",
    "rate": "I cannot tell how fast it moved: this model was not trained for amounts.",
}

NEEDS_MORE = {
    "comparison": "I see one clip only; give me a second one to compare it with.",
    "order": "I see one motion per clip; give me the parts as clips of their own, in order.",
}
"""Kinds that one clip never answers, whatever the model."""

FROM_DIRECTION = "Told by rule from the direction: this model was not trained for {}."
FROM_GEOMETRY = "Told by rule from the geometry: this model was not trained for evidence."

VERDICTS = ("verify", "negation", "premise")
"""Kinds whose answers say yes or no to a claim, and tell the motion with it."""

_ASKED_ABOUT = {
    "negation": "denied claims",
    "viewpoint": "other viewpoints",
    "actor": "the sensor's own motion",
    "thread": "threads",
    "mirrored": "mirrored clips",
    "reversed": "clips played backwards",
    "premise": "claims taken for granted",
    "confidence": "its own confidence",
    "undo": "undoing",
}


def in_words(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    frame: FrameSpec,
    listen: Overhear | None = None,
) -> Answer:
    """Answer a question whose kind the model was trained on; `listen` hears its words so far."""
    heard = hear(bundle, encoded, question, listen)
    if is_ruled_out(question, heard.slots and heard.slots.kind):
        kind = asked_kind(question)
        if kind in RETOLD:
            return _from_open_question(bundle, encoded, question, kind, frame)
        heard = _heard_again(bundle, encoded, question, heard, kind)
    slots = heard.slots
    if passes_over_moving(slots, question):
        heard = _heard_again(bundle, encoded, question, heard, "moving")
        slots = heard.slots
    if passes_over_a_claim(slots, question):
        return _from_open_question(bundle, encoded, question, "verify", frame)
    if passes_over_a_choice(slots, question):
        return _from_open_question(bundle, encoded, question, "choice", frame)
    if slots is None:
        answer = plain(encoded, NOT_UNDERSTOOD, None, frame, heard.timing_ms)
        return replace(answer, options=heard.options)
    if answers_what_it_cannot(slots, question) and "refusal" in bundle.grammar.kinds:
        text = bundle.grammar.sentence(Slots("refusal"))
        return plain(encoded, text, "refusal", frame, heard.timing_ms)
    if slots.kind in NEEDS_MORE:
        return plain(encoded, NEEDS_MORE[slots.kind], slots.kind, frame, heard.timing_ms)
    if slots.kind == "confidence":
        return _from_open_question(bundle, encoded, question, slots.kind, frame)
    if denies_nothing(slots, question):
        return _from_open_question(bundle, encoded, question, slots.kind, frame)
    if slots.kind in VERDICTS and denies_the_open_answer(slots, open_motion(bundle, encoded)):
        return _from_open_question(bundle, encoded, question, slots.kind, frame)
    if contradicts_itself(slots, question):
        heard = replace(heard, slots=replace(slots, verdict=None))
        return _retold(bundle, encoded, question, heard, frame)
    if slots.kind in ALWAYS_RETOLD or (slots.kind in RETOLD and not is_as_seen(frame)):
        return _retold(bundle, encoded, question, heard, frame)
    if slots.unit is not None:
        return answer_measured(bundle, encoded, question, heard, frame)
    told = Told(
        text=heard.text,
        direction=slots.direction,
        frame=CAMERA if slots.kind == "evidence" else frame,
        options=heard.options,
        decided=deciding_word(slots),
        is_refusal=slots.kind == "refusal",
    )
    answer = unless_withheld(bundle, encoded, told, slots, heard.timing_ms)
    is_as_heard = answer.text == heard.text and not heard.is_by_rule
    return replace(answer, told_by="model") if is_as_heard else answer


def _heard_again(
    bundle: Bundle, encoded: Encoded, question: str, heard: Heard, kind: str | None
) -> Heard:
    """Return what the model says of the kind the words tell, or of one that they do not rule out.

    For amounts and evidence it is asked in words it knows.
    """
    if kind in KNOWN_WORDS:
        again = hear(bundle, encoded, KNOWN_WORDS[kind])
        again = replace(again, is_by_rule=True)
    else:
        kinds = bundle.grammar.kinds - LATER_KINDS
        if not offered_letters(question):
            kinds -= {"choice"}
        again = hear_likeliest(bundle, encoded, question, kinds)
    spent = {
        stage: heard.timing_ms.get(stage, 0.0) + again.timing_ms.get(stage, 0.0)
        for stage in heard.timing_ms | again.timing_ms
    }
    return replace(again, timing_ms=spent)


def open_motion(bundle: Bundle, encoded: Encoded) -> Motion | None:
    """Return the motion that the model tells when it is asked openly, in the camera image."""
    slots = hear(bundle, encoded, OPEN_QUESTION).slots
    return slots and slots.direction


def denies_the_open_answer(slots: Slots, motion: Motion | None) -> bool:
    """Tell whether a verdict is told with another motion than the open question is answered with.

    Of 68 real turns 14 were told to slide when asked whether they do, and 66 told rightly when
    asked openly: one clip must not move in two ways, and the open answer is the surer one.

    Args:
        slots: Of the verdict.
        motion: What the model tells when it is asked openly; None where that does not parse.
    """
    return motion is not None and slots.direction != motion


def denies_nothing(slots: Slots, question: str) -> bool:
    """Tell whether a "no" answers a question in which no rule finds a motion to say no to.

    The model then took words it does not know for a claim: the motion is read once more from a
    question it knows, and a verdict given only where the question claims a kind of motion.
    """
    is_no = slots.kind in ("verify", "premise") and slots.verdict is False
    return is_no and not motions_named(question) and not nearly_named(question)


def passes_over_a_claim(slots: Slots | None, question: str) -> bool:
    """Tell whether the model declines to judge a claim of motion, or speaks of another thing.

    It may tell of contact, or that it moves and not how: the claim's words are then new to it. What
    presses on the gel or rests on it touches it, so that such a question may well be about contact.
    No question of the templates about contact or about motion as such passes for a claim.
    """
    if asked_kind(question) is not None or not claims_motion(question):
        return False
    if slots is None:
        return True
    is_over = claims_end(question)
    of_contact = not is_over and claimed_motion(question) in (Motion.PRESS, Motion.STILL)
    of_motion = slots.kind in ("refusal", "moving", "class", "direction")
    return of_motion or (slots.kind == "contact" and not of_contact)


def answers_what_it_cannot(slots: Slots, question: str) -> bool:
    """Tell whether the model tells of the motion where the words ask for what touch cannot tell."""
    return slots.kind != "refusal" and asks_beyond_touch(question)


def passes_over_moving(slots: Slots | None, question: str) -> bool:
    """Tell whether the model speaks of another thing where the words ask whether it moves."""
    passes = slots is None or slots.kind in ("refusal", "contact", "verify")
    return passes and asks_whether_moving(question)


def passes_over_a_choice(slots: Slots | None, question: str) -> bool:
    """Tell whether the model gives another answer than one of the motions it may choose among.

    It has read letters before their options alone; "cw/ccw?" offers two without any.
    """
    if asked_kind(question) is not None:
        return False
    offered = offered_options(question)
    if len(offered) > 1:
        if (
            slots is None
            or slots.kind != "choice"
            or not offered.keys() <= offered_letters(question)
        ):
            return True
        return offered.get(slots.letter, slots.direction) != slots.direction
    is_verdict = slots is not None and slots.kind in VERDICTS
    return is_verdict and claimed(question) is None and len(motions_named(question)) > 1


def contradicts_itself(slots: Slots, question: str) -> bool:
    """Tell whether a verdict on the motion that `question` claims denies the motion told with it.

    "Yes, it is pressing in." then answers "Is it just resting there?": the model took words it does
    not know for another claim. The rules read the claim of all of 3,600 questions from the
    templates rightly, a quarter of their wordings held out of training.
    """
    claims = claimed(question)
    if slots.verdict is None or slots.kind not in VERDICTS or claims is None:
        return False
    if claimed_motion(question) is None and (slots.kind != "verify" or nearly_named(question)):
        return False
    return slots.verdict != ((slots.direction in claims) != (slots.kind == "negation"))


def by_rule(bundle: Bundle, encoded: Encoded, question: str, kind: str, frame: FrameSpec) -> Answer:
    """Answer a question of a kind the model was not trained on, or say that it was not."""
    if kind in NEEDS_MORE or kind in UNTRAINED:
        return plain(encoded, (NEEDS_MORE | UNTRAINED)[kind], kind, frame)
    if kind == "evidence":
        clause = halves(evidence(encoded)["regions"])
        text = f"{clause[:1].upper()}{clause[1:]}, in the camera image."
        answer = plain(encoded, text, kind, CAMERA)
        notes = (*answer.notes, FROM_GEOMETRY)
        return replace(answer, abstained=False, confidence=1.0, notes=notes)
    answer = _from_open_question(bundle, encoded, question, kind, frame)
    return replace(answer, notes=(*answer.notes, FROM_DIRECTION.format(_ASKED_ABOUT[kind])))


def is_as_seen(frame: FrameSpec) -> bool:
    """Tell whether `frame` names every direction as the camera image shows it."""
    return replace(frame, contact_side=None, thread=None, mm_per_px=None) == CAMERA


def _from_open_question(
    bundle: Bundle, encoded: Encoded, question: str, kind: str, frame: FrameSpec
) -> Answer:
    heard = hear(bundle, encoded, OPEN_QUESTION)
    if heard.slots is None or heard.slots.direction is None:
        return plain(encoded, NOT_UNDERSTOOD, kind, frame, heard.timing_ms)
    # The verdict, if the model gave one, was on another question.
    slots = replace(heard.slots, kind=kind, verdict=None)
    return _retold(bundle, encoded, question, replace(heard, slots=slots), frame)


def _retold(
    bundle: Bundle, encoded: Encoded, question: str, heard: Heard, frame: FrameSpec
) -> Answer:
    slots, options = heard.slots, heard.options
    if not set(options) <= {motion.value for motion in Motion}:
        # Probabilities of a verdict or of letters name no motion: those of the open question do.
        options = score(bundle, encoded, OPEN_QUESTION, "direction")
    probabilities = {Motion(word): share for word, share in options.items()}
    felt = Felt(slots.kind, slots.direction, question, frame, probabilities, slots.verdict)
    return unless_withheld(bundle, encoded, retell(felt), slots, heard.timing_ms)
