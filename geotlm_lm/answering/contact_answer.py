"""Where in the picture the contact is, read off the contact mask; no model is asked."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from geotlm_lm.answering.abstention import neutral_answer, shows_contact, too_little_contact
from geotlm_lm.answering.answer import Answer, evidence
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.contact_location import place_in_picture
from geotlm_lm.conversation.motion_answers import CAMERA
from geotlm_lm.conversation.reasons import contact_place
from geotlm_lm.conversation.wording import capitalised


def answer_contact_location(bundle: Bundle, encoded: Encoded) -> Answer:
    """Say where the contact is, by the mask of the view."""
    seen = evidence(encoded)
    if not shows_contact(bundle, encoded):
        text = too_little_contact("say where", seen["contact_share"])
        return neutral_answer(encoded, text, "contact", CAMERA)
    text = _contact_location_phrase(encoded, seen)
    return replace(
        neutral_answer(encoded, text, "contact", CAMERA), abstained=False, confidence=1.0
    )


def _contact_location_phrase(encoded: Encoded, seen: dict[str, Any]) -> str:
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
