"""Exact phrases that state a fact about a recording, and the `FrameSpec` fields they set."""

from __future__ import annotations

from typing import Any

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.core.frame_spec import FrameSpec

_PHRASES = Phrases("frame_fact_patterns")
_UPSIDE_DOWN, UPRIGHT = FrameSpec.fields_of_turn(180), FrameSpec.fields_of_turn(0)

FACTS: tuple[tuple[str, dict[str, Any]], ...] = (
    (_PHRASES.text("MIRRORED"), {"image_mirrored": True}),
    (_PHRASES.text("MIRRORED_VERTICALLY"), {"image_mirrored": True, **_UPSIDE_DOWN}),
    (_PHRASES.text("A_MIRRORED_IMAGE"), {"image_mirrored": True}),
    (_PHRASES.text("A_MIRROR"), {"image_mirrored": True}),
    (_PHRASES.text("NOT_MIRRORED"), {"image_mirrored": False}),
    (_PHRASES.text("NO_MIRROR"), {"image_mirrored": False}),
    (_PHRASES.text("UPSIDE_DOWN"), _UPSIDE_DOWN),
    (_PHRASES.text("NOT_UPSIDE_DOWN"), {"image_upside_down": False}),
    (_PHRASES.text("UPRIGHT"), UPRIGHT),
    (_PHRASES.text("MIRRORED_AND_UPSIDE_DOWN"), {"image_mirrored": True, **_UPSIDE_DOWN}),
    (_PHRASES.text("FROM_THE_OBJECT"), {"viewpoint": "object"}),
    (_PHRASES.text("AT_THE_OBJECT"), {"viewpoint": "object"}),
    (_PHRASES.text("FROM_THE_SENSOR"), {"viewpoint": "sensor"}),
    (_PHRASES.text("SENSOR_MOVED"), {"actor": "sensor"}),
    (_PHRASES.text("SENSOR_MOVED_THING_STAYED"), {"actor": "sensor"}),
    (_PHRASES.text("THING_STAYED_SENSOR_MOVED"), {"actor": "sensor"}),
    (_PHRASES.text("I_MOVE_THE_SENSOR"), {"actor": "sensor"}),
    (_PHRASES.text("OBJECT_FIXED"), {"actor": "sensor"}),
    (_PHRASES.text("OBJECT_MOVED"), {"actor": "object"}),
    (_PHRASES.text("SENSOR_FIXED"), {"actor": "object"}),
    (_PHRASES.text("AT_THE_HEAD"), {"contact_side": "head"}),
    (_PHRASES.text("AT_THE_SHANK"), {"contact_side": "shank"}),
    (_PHRASES.text("AT_THE_SIDE"), {"contact_side": "side"}),
    (_PHRASES.text("LEFT_HAND"), {"thread": "left"}),
    (_PHRASES.text("REVERSED_THREAD"), {"thread": "left"}),
    (_PHRASES.text("RIGHT_HAND"), {"thread": "right"}),
    (_PHRASES.text("USUAL_THREAD"), {"thread": "right"}),
    (_PHRASES.text("FORGET_THE_SCALE"), {"mm_per_px": None}),
    (
        _PHRASES.text("RESET"),
        {
            "image_mirrored": False,
            "viewpoint": "sensor",
            "actor": "object",
            "contact_side": None,
            "thread": None,
            "mm_per_px": None,
            **UPRIGHT,
        },
    ),
)
"""What may be said, to the letter, and the fields of `FrameSpec` it sets."""
