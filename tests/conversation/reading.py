"""What is read of a question, by its words alone, gathered into one plain value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, fields, is_dataclass
from enum import Enum
from typing import Any

from geotlm_lm.answering import question_routing
from geotlm_lm.answering.understanding import kind_by_rule
from geotlm_lm.conversation.alternatives import asks_alternatives
from geotlm_lm.conversation.axis_claims import asks_components, claimed_axis
from geotlm_lm.conversation.compound_claims import compound_claim
from geotlm_lm.conversation.compound_questions import split_questions
from geotlm_lm.conversation.courtesies import without_courtesies
from geotlm_lm.conversation.either_or import asked_whether_over
from geotlm_lm.conversation.english import is_english
from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.frame_questions import asks_frame, asks_which_moves
from geotlm_lm.conversation.future_questions import asks_future_motion
from geotlm_lm.conversation.half_directions import asked_half, claimed_half
from geotlm_lm.conversation.hypothetical_changes import (
    claimed_inverse,
    claims_on_changed_clip,
    supposed_changes,
)
from geotlm_lm.conversation.image_rotation import unclear_rotation
from geotlm_lm.conversation.kind_choices import offered_kinds
from geotlm_lm.conversation.kinds import asked_kind, asks_direction, asks_whether_moving
from geotlm_lm.conversation.likelihood_questions import likelihood_subject
from geotlm_lm.conversation.motion_answers import CAMERA
from geotlm_lm.conversation.motion_claims import (
    asks_both_kinds,
    asks_yes_or_no,
    claimed_motion_class,
    claimed_motions,
    offered_options,
    presumed_class,
)
from geotlm_lm.conversation.option_meanings import offers_neither, option_sets
from geotlm_lm.conversation.pixel_scale import asks_scale, with_pixel_size
from geotlm_lm.conversation.recording_questions import recording_topic
from geotlm_lm.conversation.requested_units import requested_unit
from geotlm_lm.conversation.stated_amounts import (
    claimed_amount,
    claims_unread_amount,
    denies_amount,
)
from geotlm_lm.conversation.two_clip_claims import (
    asks_inverse,
    asks_same_amount,
    claimed_count,
    claimed_each,
    claimed_relation,
    claimed_subject,
    claimed_transform,
    claims_same_kind,
    supposed_transform,
)
from geotlm_lm.conversation.two_clip_questions import asks_each_amount, asks_of_one
from geotlm_lm.conversation.unanswerable import asks_place, never_answered_reply, unanswerable_reply
from geotlm_lm.core.frame_spec import FrameSpec

CHANGES = ("mirrored", "reversed", "undo", "viewpoint", "actor")

OF_ONE: Mapping[str, Callable[[str], Any]] = {
    "kind": lambda text: asked_kind(text) or (asks_direction(text) and "direction") or None,
    "answered_as": kind_by_rule,
    "is_claim": asks_yes_or_no,
    "asks_whether_moving": asks_whether_moving,
    "claim": claimed_motions,
    "claimed_class": claimed_motion_class,
    "presumed_class": presumed_class,
    "whole_claim": compound_claim,
    "axis": lambda text: claimed_axis(text.lower()),
    "components": asks_components,
    "choice": offered_options,
    "option_sets": option_sets,
    "neither": offers_neither,
    "kinds_offered": offered_kinds,
    "both_kinds": asks_both_kinds,
    "half": asked_half,
    "claimed_half": claimed_half,
    "amount": claimed_amount,
    "unread_amount": claims_unread_amount,
    "denied_amount": denies_amount,
    "unit": lambda text: requested_unit(text, "deg") or requested_unit(text, "px"),
    "alternatives": asks_alternatives,
    "recording": recording_topic,
    "scale": asks_scale,
    "frame_asked": asks_frame,
    "which_moves": asks_which_moves,
    "over": lambda text: asked_whether_over(text) is not None,
    "future": asks_future_motion,
    "place": asks_place,
    "parts": lambda text: split_questions(text) is not None,
    "untold": lambda text: (never_answered_reply(text) or unanswerable_reply(text)) is not None,
}
OF_TWO: Mapping[str, Callable[[str], Any]] = {
    "relation": claimed_relation,
    "share": claimed_count,
    "each": claimed_each,
    "subject": claimed_subject,
    "image": claimed_transform,
    "supposed": lambda text: (said := supposed_transform(text)) and said[1:],
    "same_kind": claims_same_kind,
    "same_amount": asks_same_amount,
    "each_amount": asks_each_amount,
    "undoing": asks_inverse,
    "clip": lambda text: (said := asks_of_one(text)) and said[0],
}


def reading(text: str, columns: int) -> dict[str, Any]:
    """Return what `text` is read as: what is not read is left out.

    Args:
        text: As somebody types it.
        columns: Width of the recording's frames, which the size of a picture is told by.
    """
    said = with_pixel_size(without_courtesies(text), columns)
    if not is_english(said):
        return {"is_english": False}
    stated = read_facts(said, CAMERA)
    found: dict[str, Any] = {"frame": _told(stated.frame)}
    if stated.lasting != stated.frame:
        found["lasting"] = _told(stated.lasting)
    if not stated.rest:
        return {"is_fact": True} | found
    if unclear_rotation(stated.rest, said) is not None:
        return {"lacks": "turn"} | found
    asked, frame = question_routing._canonical_question(stated.rest, stated.frame)
    found["frame"] = _told(frame)
    found |= {name: read(asked) for name, read in OF_ONE.items()}
    if found["kind"] in CHANGES:
        found["changes"] = supposed_changes(asked, found["kind"]).names
        found["claim_of_change"] = claims_on_changed_clip(asked)
        found["remedy"] = claimed_inverse(asked)
    if found["kind"] == "confidence":
        found["doubted"] = likelihood_subject(asked)
    found["of_two"] = _without_empty({name: read(stated.rest) for name, read in OF_TWO.items()})
    return _without_empty(found)


def _told(frame: FrameSpec) -> dict[str, Any]:
    told = asdict(frame)
    return {name: value for name, value in told.items() if value != getattr(CAMERA, name)}


def _without_empty(found: Mapping[str, Any]) -> dict[str, Any]:
    values = {name: _plain(value) for name, value in found.items()}
    return {
        name: value
        for name, value in values.items()
        if value is not None and value is not False and value not in ({}, [])
    }


def _plain(value: Any) -> Any:
    if isinstance(value, Enum):
        return value.value
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, frozenset | set):
        return sorted(_plain(one) for one in value)
    if isinstance(value, tuple | list):
        return [_plain(one) for one in value]
    if isinstance(value, Mapping):
        return {str(name): _plain(one) for name, one in value.items()}
    return value if value is None or isinstance(value, bool | int | float) else str(value)
