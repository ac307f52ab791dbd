"""The facts about a recording that can be checked in the page, and the frame they stand for."""

from __future__ import annotations

from typing import Any

from geotlm_lm import FrameSpec, Motion

from . import handlers

MIRRORED, UPSIDE_DOWN = "image is mirrored", "image is upside down"
CLOCKWISE = "image is turned 90° clockwise"
COUNTERCLOCKWISE = "image is turned 90° counterclockwise"
TURNS = {UPSIDE_DOWN: 180, CLOCKWISE: 90, COUNTERCLOCKWISE: 270}
OTHER_SIDE, SENSOR_MOVES = "seen from the object", "sensor moves"


def fields_of(facts: list[str]) -> dict[str, Any]:
    """Return the fields of a `FrameSpec` that the checked facts stand for; turns add up."""
    turned = sum(degrees for fact, degrees in TURNS.items() if fact in facts)
    return FrameSpec.fields_of_turn(turned) | {
        "image_mirrored": MIRRORED in facts,
        "viewpoint": "object" if OTHER_SIDE in facts else "sensor",
        "actor": "sensor" if SENSOR_MOVES in facts else "object",
    }


def facts_of(frame: FrameSpec) -> list[str]:
    """Return the facts to check for a frame: what the conversation said of it shows in the page."""
    is_so = {
        MIRRORED: frame.image_mirrored,
        UPSIDE_DOWN: frame.image_upside_down,
        CLOCKWISE: frame.image_quarter_turn == "clockwise",
        COUNTERCLOCKWISE: frame.image_quarter_turn == "counterclockwise",
        OTHER_SIDE: frame.viewpoint == "object",
        SENSOR_MOVES: frame.actor == "sensor",
    }
    return [fact for fact, is_true in is_so.items() if is_true]


def sentences_of(frame: FrameSpec) -> list[str]:
    """Return the facts of a frame as they are stated in a question; the size of a pixel is not."""
    stated = {
        MIRRORED: "The image is mirrored.",
        UPSIDE_DOWN: "The image is upside down.",
        CLOCKWISE: "The image is turned 90 degrees clockwise.",
        COUNTERCLOCKWISE: "The image is turned 90 degrees counterclockwise.",
        OTHER_SIDE: "I look from the object's side.",
        SENSOR_MOVES: "The object is fixed and the sensor moves.",
    }
    return [stated[fact] for fact in facts_of(frame)]


def frame_preview(facts: list[str], direction: str | None) -> str:
    """Return the last direction as it is in the frame that the facts stand for."""
    frame = FrameSpec(**fields_of(facts))
    motion = None if direction is None else Motion(direction)
    return handlers.direction_in_frame(frame, motion)


def update_facts(facts: list[str], direction: str | None, fact: str, is_checked: bool) -> tuple:
    """Return the facts as they hold once one was checked or not, and what `frame_preview` returns.

    An image is turned by a quarter one way or the other: of both the one checked last holds.
    """
    quarters = (CLOCKWISE, COUNTERCLOCKWISE)
    replaced = quarters if is_checked and fact in quarters else (fact,)
    held = [one for one in facts if one not in replaced] + [fact] * is_checked
    return held, frame_preview(held, direction)
