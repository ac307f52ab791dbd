"""The way of a recording from its start, frame by frame, as it is played and seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.edit import Edit
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import OF_ATOM, Missing, component_of
from geotlm_lm.query.bounds import measured
from geotlm_lm.query.happenings import Limit
from geotlm_lm.query.quantities import in_base
from geotlm_lm.track.track import Track

_COLUMNS = {"turn": 0, "x": 1, "y": 2, "inward": 3}


def played(track: Track, edit: Edit) -> Track:
    """Return a track as it is played: backwards its last frame comes first.

    Its events are left out then, and its steps keep the signs that they were recorded with: an
    edit's matrix turns these round.
    """
    if not edit.backwards:
        return track
    steps = {name: getattr(track, name) for name in ("twists", "covariances")}
    steps = {name: np.roll(one, -1, axis=0)[::-1] for name, one in steps.items()}
    marks = {name: getattr(track, name) for name in ("numbers", "times_s")}
    marks = {name: (one[0] + one[-1] - one)[::-1] for name, one in marks.items()}
    states = {
        name: getattr(track, name)[::-1] for name in ("contact", "strength_grey", "radius_px")
    }
    return replace(track, **steps, **marks, **states, events=())


def crossing(said: t.Literal, edit: Edit, track: Track, limit: Limit) -> NDArray[np.float64]:
    """Return the times, seconds, at which the way from the start is more than is said.

    Of what is said per second or frame it is the speed.

    Args:
        said: A literal with a bound.
        edit: The point of view.
        track: As it is played.
        limit: Converts what is said.

    Raises:
        Missing: If it has no amount, or a speed no frame rate.
    """
    name, said_low = measured(said), said.bound.low
    sign = OF_ATOM.get(said.atom, ("", 0))[1]
    least = limit(name, said_low, 1.0)
    is_speed = bool(in_base(said_low)[2])
    way = (track.rates()[0] if is_speed else track.path_from_start) @ edit.matrix.T
    if name == "slide":
        far = np.hypot(way[:, 1], way[:, 2])
    else:
        far = way[:, _COLUMNS[name]]
        # "-20 degrees" goes against the way that is positive.
        far = far * sign if sign else np.abs(far) if least >= 0 else -far
    return track.times_s[far > abs(least)]


def peak(
    track: Track | None, edit: Edit, atom: str, *, is_speed: bool
) -> tuple[float, float, float]:
    """Return the greatest way from the start, or speed, and its deviation and time.

    Args:
        track: Of a recording.
        edit: The point of view.
        atom: Of which; of a way only what goes that way counts.
        is_speed: Whether the speed is asked for.

    Returns:
        Degrees, pixels or mm, or the same per second, its deviation, and seconds; what never goes
        the way of the atom goes 0 or less.

    Raises:
        Missing: If no recording was followed.
    """
    if track is None:
        raise Missing("track")
    name, sign = OF_ATOM[atom]
    as_played = played(track, edit)
    way = (as_played.rates()[0] if is_speed else as_played.path_from_start) @ edit.matrix.T
    doubt = as_played.path_deviations @ np.abs(edit.matrix).T
    if name == "slide":
        far, off = np.hypot(way[:, 1], way[:, 2]), np.max(doubt[:, 1:3], axis=1)
    else:
        far, off = way[:, _COLUMNS[name]], doubt[:, _COLUMNS[name]]
        far = far * sign if sign else np.abs(far)
    place = int(np.argmax(far))
    deviation = float(off[place])
    if is_speed:
        net = track.path(component_of(name))
        deviation = float(far[place]) * min(net.deviation / max(net.mean, 1e-6), 1.0)
    return float(far[place]), deviation, float(as_played.times_s[place])
