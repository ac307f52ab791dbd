"""One question about one clip, from the text as it was typed to the answer.

What needs no model is answered here: facts about the recording, what is never told, where the
contact is. A text that asks two things is answered in two parts.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from geotlm_lm.answering.alternatives import with_alternatives
from geotlm_lm.answering.amount_verdicts import judged_amount
from geotlm_lm.answering.answer import Answer, Encoded, evidence
from geotlm_lm.answering.joining import both
from geotlm_lm.answering.leaning import with_lean
from geotlm_lm.answering.overruling import read_by_rule
from geotlm_lm.answering.presumed_amounts import with_amount
from geotlm_lm.answering.replying import UNTRAINED, by_rule, from_open_question, in_words
from geotlm_lm.answering.streaming import Listener, StandingWords
from geotlm_lm.answering.withholding import plain, shows_contact, too_little_contact
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.about_recording import (
    Topic,
    asked_of_recording,
    told_of_recording,
)
from geotlm_lm.conversation.alternatives import asks_alternatives
from geotlm_lm.conversation.bare_amounts import asked_of_an_amount
from geotlm_lm.conversation.bare_motions import asked_of_a_motion
from geotlm_lm.conversation.claims import asks_both_kinds, without_adverbs
from geotlm_lm.conversation.clock_words import without_clocks
from geotlm_lm.conversation.context import without_context
from geotlm_lm.conversation.courtesies import without_courtesies
from geotlm_lm.conversation.denials import plainly_denied
from geotlm_lm.conversation.either_or import OF_THE_END, asked_whether_over, without_opposites
from geotlm_lm.conversation.english import ENGLISH_ONLY, is_english
from geotlm_lm.conversation.frame_facts import read_facts, turn_told_after
from geotlm_lm.conversation.frame_questions import (
    RELATIVE,
    asks_frame,
    asks_which_moves,
    frame_to_settle,
    of_another_frame,
)
from geotlm_lm.conversation.future import NOT_TO_COME, asks_what_comes
from geotlm_lm.conversation.indirect import asked_within
from geotlm_lm.conversation.kinds import asked_kind
from geotlm_lm.conversation.known_words import SLIP_IS_A_SLIDE, in_known_words, names_slip
from geotlm_lm.conversation.of_the_sensor import as_of_it, names_the_object
from geotlm_lm.conversation.option_meanings import initials_spelt_out
from geotlm_lm.conversation.place import place_in_picture
from geotlm_lm.conversation.plain_text import plain_text
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.reasons import contact_place
from geotlm_lm.conversation.reported import asked_of_report
from geotlm_lm.conversation.retell import CAMERA
from geotlm_lm.conversation.scale import asks_scale, told_scale, with_pixel_size
from geotlm_lm.conversation.short_questions import in_full
from geotlm_lm.conversation.signed_axes import (
    CLOCKWISE_IS_POSITIVE,
    asked_of_axes,
    asks_sign_of_turn,
    counts_pixels,
)
from geotlm_lm.conversation.spelling import as_words, spelt
from geotlm_lm.conversation.stated_amounts import (
    UNJUDGED,
    claimed_amount,
    claims_unread_amount,
)
from geotlm_lm.conversation.statements import TURN_TOLD_AFTER, UNREAD, states_more
from geotlm_lm.conversation.thread_words import of_a_thread
from geotlm_lm.conversation.turned_image import unclear_turn
from geotlm_lm.conversation.two_parts import two_parts
from geotlm_lm.conversation.untold import ONE_KIND, asks_place, never_told, untold
from geotlm_lm.conversation.wording import capitalised, known
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, ROTATIONS


def answer_question(
    bundle: Bundle,
    encoded: Encoded,
    question: str,
    frame: FrameSpec,
    listen: Listener | None = None,
) -> Answer:
    """Answer a question that is neither empty nor too long.

    Args:
        bundle: The model.
        encoded: The clip.
        question: As it was typed.
        frame: In which to tell directions.
        listen: Told the model's words piece by piece, as far as they stand in the answer.
    """
    question = with_pixel_size(without_courtesies(question), encoded.clip.frames.shape[2])
    if not is_english(question):
        return plain(encoded, ENGLISH_ONLY, None, frame)
    stated = read_facts(question, frame)
    if turn_told_after(stated.rest):
        rest = stated.rest[: stated.rest.rindex("?") + 1]
        answer = answer_question(bundle, encoded, rest, stated.frame, listen)
        return replace(answer, notes=(*answer.notes, TURN_TOLD_AFTER))
    if not stated.rest:
        noted = plain(encoded, f"Noted: {known(stated.frame)}.", "frame", stated.frame)
        return replace(noted, abstained=False, confidence=1.0)
    if (missing := unclear_turn(stated.rest, question)) is not None:
        return plain(encoded, missing, "frame", stated.frame)
    if (settled := frame_to_settle(stated.rest, stated.frame)) is not None:
        return plain(encoded, settled, "frame", stated.frame)
    if not stated.is_stated and states_more(stated.rest):
        return plain(encoded, UNREAD, "frame", frame)
    asked, frame = _as_known(stated.rest, stated.frame)
    is_whole = plain_text(stated.rest) == plain_text(question)  # nothing supposed, no fact told
    if is_whole and asks_what_comes(asked):
        return plain(encoded, NOT_TO_COME, "refusal", frame)
    answer = _of_other_questions(bundle, encoded, asked, frame)
    if answer is None:
        answer = _at_once(bundle, encoded, asked, frame)
    if answer is not None:
        return answer
    kind, read = asked_kind(asked), read_by_rule(asked)
    if read is not None:
        answer = from_open_question(bundle, encoded, asked, read, frame)
    elif kind is not None and kind not in bundle.grammar.kinds:
        answer = by_rule(bundle, encoded, asked, kind, frame)
    else:
        words = listen and StandingWords(bundle, encoded, asked, frame, listen)
        answer = in_words(bundle, encoded, asked, frame, words)
    answer = with_amount(bundle, encoded, asked, answer)
    answer = with_lean(bundle, encoded, asked, answer)
    return _with_meaning_told(stated.rest, asked, answer)


def _as_known(text: str, frame: FrameSpec) -> tuple[str, FrameSpec]:
    """Return what a text asks, spelt rightly and in words that rules and model know.

    With it the frame to answer in: who names the sensor or the object asks of that one's motion,
    and rows and columns are those of the image as it was recorded.
    """
    if counts_pixels(text):
        frame = CAMERA
    asked = _in_known_words(text, frame)
    if (of_it := as_of_it(asked)) is not None:
        return _in_bare_words(of_it), replace(frame, actor="sensor")
    if frame.actor == "sensor" and names_the_object(asked):
        frame = replace(frame, actor="object")
    return _in_bare_words(asked), frame


def _in_bare_words(asked: str) -> str:
    """Return a question for a motion or an amount and no more in words that every model knows."""
    return asked_of_a_motion(asked) or asked_of_an_amount(asked) or asked


def _in_known_words(text: str, frame: FrameSpec) -> str:
    words = plainly_denied(
        as_words(without_context(spelt(without_clocks(initials_spelt_out(text)))))
    )
    asked = without_opposites(without_adverbs(in_full(asked_within(words))))
    asked = asked_of_report(asked) or asked
    asked = asked_of_axes(asked) or in_known_words(asked)
    return of_a_thread(asked, frame.thread is not None)


def _of_other_questions(
    bundle: Bundle, encoded: Encoded, asked: str, frame: FrameSpec
) -> Answer | None:
    """Return the answer to what asks, in other words, for answers to one question or to two."""
    if asks_alternatives(asked):
        return with_alternatives(answer_question(bundle, encoded, OPEN_QUESTION, frame))
    if (limited := _as_far_as_known(asked)) is not None:
        rest, limit = limited
        answer = answer_question(bundle, encoded, rest, frame)
        return replace(answer, notes=(*answer.notes, limit)) if _limits(limit, answer) else answer
    parts = two_parts(asked)
    if parts is None:
        return None
    return both(*(answer_question(bundle, encoded, part, frame) for part in parts))


def _limits(limit: str, answer: Answer) -> bool:
    """Tell whether an answer is less than was asked for; one without a way is the same anywhere."""
    if limit == OF_THE_END:
        return answer.decided == "yes"
    return limit == ONE_KIND or (answer.direction in DIRECTED and answer.kind not in _WITHOUT_WAY)


_WITHOUT_WAY = ("magnitude", "rate", "moving", "contact", "class", "confidence")
"""Kinds whose answers are the same from every side."""


def _as_far_as_known(asked: str) -> tuple[str, str] | None:
    """Return what of a question a recording tells of, and what it does not; None where it may all.

    Whether a motion is over is limited only where it goes at all.
    """
    if (another := of_another_frame(asked)) is not None:
        return another
    if asks_both_kinds(asked):
        return OPEN_QUESTION, ONE_KIND
    going = asked_whether_over(asked)
    return None if going is None else (going, OF_THE_END)


def _with_meaning_told(said: str, asked: str, answer: Answer) -> Answer:
    """Return an answer on a turn with a note on what the question's words are taken to mean.

    What slip is taken for is told where it is denied, and which sign of an angle is which way where
    a sign is asked after.

    Args:
        said: The question before it was put into known words.
        asked: And after.
        answer: The answer to it.
    """
    if answer.direction not in ROTATIONS:
        return answer
    if asks_sign_of_turn(said):
        return replace(answer, notes=(*answer.notes, CLOCKWISE_IS_POSITIVE))
    if answer.decided == "no" and names_slip(asked):
        return replace(answer, notes=(*answer.notes, SLIP_IS_A_SLIDE))
    return answer


def _at_once(bundle: Bundle, encoded: Encoded, asked: str, frame: FrameSpec) -> Answer | None:
    """Return the answer to what no model is asked, or not in these words; None to anything else."""
    if (topic := asked_of_recording(asked)) is not None:
        return _of_recording(encoded, topic, frame)
    if asks_scale(asked):
        said = plain(encoded, told_scale(frame.mm_per_px), "frame", frame)
        is_known = frame.mm_per_px is not None
        return replace(said, abstained=False, confidence=1.0) if is_known else said
    if asks_frame(asked):
        said = plain(encoded, f"I tell directions in this frame: {known(frame)}.", "frame", frame)
        return replace(said, abstained=False, confidence=1.0)
    if asks_which_moves(asked):
        return plain(encoded, RELATIVE, "refusal", frame)
    kind = asked_kind(asked)
    said = never_told(asked) or (untold(asked) if kind is None else None)
    if said is not None:
        return plain(encoded, said, "refusal", frame)
    if kind in (None, "magnitude", "evidence", "actor") and asks_place(asked):
        return _place(bundle, encoded)
    claim = claimed_amount(asked)
    if claim is None:
        is_unread = claims_unread_amount(asked)
        return plain(encoded, UNJUDGED, "magnitude", frame) if is_unread else None
    asks_for = "rate" if claim.is_speed else "magnitude"
    if asks_for not in bundle.grammar.kinds:
        return plain(encoded, UNTRAINED[asks_for], asks_for, frame)
    return judged_amount(bundle, encoded, asked, claim, frame)


def _of_recording(encoded: Encoded, topic: Topic, frame: FrameSpec) -> Answer:
    """Say what is known of the frames, whatever they show."""
    clip = encoded.clip
    text = told_of_recording(topic, clip.frames.shape[1:3], clip.fps, clip.frame_numbers)
    return replace(plain(encoded, text, "frame", frame), abstained=False, confidence=1.0)


def _place(bundle: Bundle, encoded: Encoded) -> Answer:
    """Say where the contact is, by the mask of the view."""
    seen = evidence(encoded)
    if not shows_contact(bundle, encoded):
        text = too_little_contact("say where", seen["contact_share"])
        return plain(encoded, text, "contact", CAMERA)
    text = _place_in_words(encoded, seen)
    return replace(plain(encoded, text, "contact", CAMERA), abstained=False, confidence=1.0)


def _place_in_words(encoded: Encoded, seen: dict[str, Any]) -> str:
    view = encoded.view
    if view is None or seen["contact_centre_px"] is None:
        place = contact_place(seen["regions"], seen["contact_share"])
        return f"{capitalised(place)}."
    (x, y), (rows, columns) = seen["contact_centre_px"], encoded.clip.frames.shape[1:3]
    picture = view.picture_height_px * view.picture_width_px
    share = min(seen["contact_share"] * view.side_px**2 / picture, 1.0)
    return (
        f"In the {place_in_picture(x / columns, y / rows)} of the camera image: its middle is "
        f"around {x:.0f} px from the left and {y:.0f} px from the top of {columns} x {rows}, and "
        f"it covers about {share:.0%} of the image."
    )
