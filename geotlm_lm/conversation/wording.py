"""Put a motion and a frame of reference into words; every direction names its frame once."""

from __future__ import annotations

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, MotionClass

KIND_SENTENCES = {
    MotionClass.ROTATION: "A rotation.",
    MotionClass.SLIDE: "A slide.",
    MotionClass.PRESS: "A press.",
    MotionClass.RELEASE: "A release.",
    MotionClass.STILL: "A still contact.",
    MotionClass.NONE: "No contact.",
}
"""The answer to "which kind of motion?", as the templates have it."""

_CLAUSES = {
    Motion.PRESS: "it is pressing in",
    Motion.RELEASE: "it is lifting off",
    Motion.STILL: "it is touching but not moving",
    Motion.NONE: "the gel is untouched",
}

_GERUNDS = {
    Motion.PRESS: "pressing in",
    Motion.RELEASE: "lifting off",
    Motion.STILL: "holding still",
    Motion.NONE: "not touching",
}


def frame_phrase(frame: FrameSpec) -> str:
    """Return the frame of a direction as a phrase: "in the camera image"."""
    is_from_sensor = frame.viewpoint == "sensor"
    seen = "in the camera image" if is_from_sensor else "seen from the object's side"
    turned, mirrored = frame.turning(), ["the mirror undone"] * frame.image_mirrored
    if turned and is_from_sensor and not mirrored:
        return f"{seen} {turned}"
    changed = [f"the image {turned}"] if turned else []
    # Of a quarter turn and a mirror the order matters, and is that of `FrameSpec`.
    changed = changed + mirrored if frame.image_quarter_turn else mirrored + changed
    return f"{seen} with {' and '.join(changed)}" if changed else seen


def motion_phrase(motion: Motion) -> str:
    """Return a motion as a phrase without frame: "clockwise", "pressing in"."""
    return motion.value if motion in DIRECTED else _GERUNDS[motion]


def direction_clause(told: Motion, frame: FrameSpec) -> str:
    """Return a motion as a clause with its frame: "it goes left in the camera image"."""
    if told not in DIRECTED:
        return _CLAUSES[told]
    who = "the sensor" if frame.actor == "sensor" else "it"
    return f"{who} goes {told.value} {frame_phrase(frame)}"


def confidence_level(probability: float) -> str:
    """Return a probability as a word: high from 0.9, medium from 0.6, low below."""
    return "high" if probability >= 0.9 else "medium" if probability >= 0.6 else "low"


def frame_summary(frame: FrameSpec) -> str:
    """Return all known facts of the frame in one clause."""
    facts = [frame.sentence()]
    if frame.thread is not None:
        facts.append(f"{frame.thread}-hand thread")
    if frame.contact_side is not None:
        facts.append(f"touched at its {frame.contact_side}")
    if frame.mm_per_px is not None:
        facts.append(f"{frame.mm_per_px:g} mm per pixel")
    return ", ".join(facts)


def capitalised(text: str) -> str:
    """Return `text` as a sentence begins, its other letters as they are."""
    return f"{text[:1].upper()}{text[1:]}"


def decapitalised(text: str) -> str:
    """Return `text` as it goes on within a sentence, its other letters as they are."""
    return f"{text[:1].lower()}{text[1:]}"
