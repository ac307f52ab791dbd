"""What answers about an encoded clip rest on, as `query` takes it, and as plain values."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.reasons import contact_place, halves
from geotlm_lm.query.amounts import Recording
from geotlm_lm.query.evaluate import ContactArea, Evidence
from geotlm_lm.query.worlds import worlds_of_clip, worlds_of_track


def evidence_of(encoded: Encoded, seed: int = 0) -> Evidence:
    """Return what answers about a clip rest on.

    Args:
        encoded: The clip.
        seed: Of its possible worlds; clips that are compared have different ones.
    """
    values, track = encoded.regions, encoded.track
    reasons = (
        f"{_capitalised(contact_place(values['regions'], values['contact_share']))}.",
        f"{_capitalised(halves(values['regions']))}.",
    )
    belief = encoded.belief
    worlds = worlds_of_clip(belief, seed) if track is None else worlds_of_track(track, belief, seed)
    area = None if encoded.is_untouched else _area(encoded, values)
    return Evidence(worlds, recording_of(encoded), area, reasons)


def recording_of(encoded: Encoded) -> Recording:
    """Return the facts about the file that a clip is of."""
    clip, track = encoded.clip, encoded.track
    rows, columns = clip.frames.shape[1:3]
    step_s = None
    if track is not None:
        step_s = float(np.median(np.diff(track.times_s)) / np.median(np.diff(track.numbers)))
    return Recording(
        columns=columns,
        rows=rows,
        rate_hz=clip.fps,
        frames=clip.recorded_frames,
        duration_s=clip.recorded_s,
        is_uneven=bool(clip.times_s),
        used=clip.frame_numbers,
        step_s=step_s,
    )


def regions_of(encoded: Encoded) -> dict[str, Any]:
    """Return the geometry an answer rests on, as plain values that are the caller's own."""
    return deepcopy(encoded.regions)


def _area(encoded: Encoded, values: dict[str, Any]) -> ContactArea | None:
    view, centre = encoded.view, values["contact_centre_px"]
    if view is None or centre is None:
        return None
    rows, columns = encoded.clip.frames.shape[1:3]
    picture = view.picture_height_px * view.picture_width_px
    share = min(values["contact_share"] * view.side_px**2 / picture, 1.0)
    return ContactArea(centre[0] / columns, centre[1] / rows, share)


def _capitalised(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"
