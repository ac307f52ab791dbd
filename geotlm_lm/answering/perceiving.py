"""Perceive a clip, or a whole recording: four frames are looked at, a longer one is tracked."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np
from torch import Tensor

from geotlm_lm.alignment.dots import activity_grey
from geotlm_lm.answering.encoded import Encoded, with_background
from geotlm_lm.checkpoint import Bundle, reading_of
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.twist import WAYS, Component
from geotlm_lm.motion.belief import Belief, fused, kept_from_zero
from geotlm_lm.query.speaker import TactilePrefix
from geotlm_lm.recordings.idle import find_idle, shows_contact
from geotlm_lm.recordings.legible import require_legible
from geotlm_lm.recordings.scene_checks import SceneReport, scene_of
from geotlm_lm.recordings.touch import (
    UNTOUCHED_GREY,
    UNTOUCHED_PROBABILITY,
    change_from_idle,
    is_static,
)
from geotlm_lm.track.block import believed, believer
from geotlm_lm.track.summed import Whole, belief_of_track
from geotlm_lm.track.track import Track, window_of
from geotlm_lm.track.tracker import Follow, Tracker, gel_of, track_of, unfollowed

CLEAR = 10.0
"""Path over its limit from which on nothing that grows feigns it."""


def belief_of(bundle: Bundle, encoded: Encoded) -> Belief:
    """Return what is believed of a clip, given its perception.

    What is faint or cut off is believed with a wider spread, and less surely. A contact that grows
    may look as if it turned or slid: where it is pressed and either of these is not far beyond its
    limit, the clip is perceived once more, played backwards, and what does not turn round with it
    is not believed.
    """
    belief = _first_belief(bundle, encoded)
    moving = [part for part in (Component.TURN, Component.SLIDE) if belief.moves(part) >= 0.5]
    doubtful = [part for part in moving if belief.path(part) < CLEAR * belief.limits.get(part, inf)]
    # Where contact is not known, nor is whether it is pressed.
    is_pressed = belief.moves(Component.PRESS) >= 0.5 or not encoded.is_contact_known
    if not (doubtful and is_pressed):
        return belief
    started, clip = time.perf_counter(), encoded.clip.reversed()
    backwards = replace(encoded, clip=clip, perception=bundle.model.perceive([clip]))
    belief = kept_from_zero(fused(belief, _first_belief(bundle, backwards)))
    encoded.timing_ms["backwards"] = 1e3 * (time.perf_counter() - started)
    return belief


def _first_belief(bundle: Bundle, encoded: Encoded) -> Belief:
    """Return what is believed of a clip seen once, and of contact by what the pictures tell too."""
    belief = believed(bundle.motion, encoded.clip, encoded.perception, encoded.doubt)
    if not encoded.is_contact_known:  # a press looks like a release then
        ways = belief.ways | dict.fromkeys(WAYS[Component.PRESS], 0.0)
        return replace(belief, ways=ways, is_contact_known=False)
    touched = _contact(belief.contact, encoded)
    ways = {way: share * touched for way, share in belief.ways.items()}
    return replace(belief, ways=ways, contact=touched)


def reading(encoded: Encoded) -> Tensor:
    """Return what the language model reads of a clip: z, then what is believed, (width,)."""
    return reading_of(encoded.perception.fused_token, [encoded.belief])[0]


def prefix_of(bundle: Bundle, encoded: Encoded) -> TactilePrefix:
    """Return how the language model sees a clip."""
    return bundle.speaker.prefix(reading(encoded).numpy())


def _contact(believed: float, encoded: Encoded) -> float:
    """Return how probable it is that something touches, by what is told and by the pictures."""
    if encoded.is_untouched:
        return 1 - UNTOUCHED_PROBABILITY
    return max(believed, UNTOUCHED_PROBABILITY) if encoded.is_changed else believed


CUT_OFF_NOTE = "The border of the image cuts the imprint off: answers are less sure."


def perceive_clip(bundle: Bundle, clip: Clip, scene: SceneReport | None = None) -> Encoded:
    """Perceive two to four frames once; fewer than four are repeated evenly.

    Args:
        bundle: The model.
        clip: The frames, with their idle gel if that is known.
        scene: What was noticed about the recording that they are of; None looks at them alone.

    Raises:
        UnreadableClip: If the frames hold no picture of a gel.
    """
    started = time.perf_counter()
    is_idle_known = clip.background is not None
    idle, clip = clip.background, require_legible(with_background(_four(clip)))
    if scene is None:
        scene = scene_of(clip, idle)
        clip = _four(scene.steadied(replace(clip, notes=(*clip.notes, *scene.notes))))
    chosen = time.perf_counter()
    change = change_from_idle(clip)
    seen = is_idle_known and change.is_beyond_noise
    untouched = change.grey < UNTOUCHED_GREY and not seen
    faint = is_idle_known and change.is_faint
    cut_off = seen and not faint and change.is_cut_off
    static = not is_idle_known and is_static(clip)
    is_contact_known = is_idle_known or shows_contact(activity_grey(clip.frames), clip.background)
    judged = time.perf_counter()
    if untouched:
        clip = clip.with_note(_nothing_seen(change.grey))
    if cut_off:
        clip = clip.with_note(CUT_OFF_NOTE)
    # Of what is not there, noise decides which motion it looks like: leave the noise out.
    frames = np.stack([clip.background] * len(clip)) if untouched else clip.frames
    perception = bundle.model.perceive([replace(clip, frames=frames)])
    done = time.perf_counter()
    timing = {
        "choose": 1e3 * (chosen - started),
        "touch": 1e3 * (judged - chosen),
        "encode": 1e3 * (done - judged),
    }
    return Encoded(
        clip,
        perception,
        timing,
        is_untouched=untouched,
        is_changed=seen and not faint,
        is_faint=faint,
        is_cut_off=cut_off,
        is_static=static,
        is_contact_known=is_contact_known,
        suspicion=scene.suspicion,
        believe=partial(belief_of, bundle),
        prefix_by=partial(prefix_of, bundle),
    )


def track_recording(
    bundle: Bundle,
    clip: Clip,
    progress: Progress = silent,
    scene: SceneReport | None = None,
    follow: Follow = unfollowed,
) -> Track:
    """Return the track of a recording in memory; its idle gel is found, learnt or guessed.

    It is steadied first, or was by the `scene` that is given.
    """
    believe, whole = believer(bundle.model, bundle.motion), _whole(bundle, clip)
    return track_of(clip, believe, whole=whole, progress=progress, scene=scene, follow=follow)


def tracker_of(bundle: Bundle, clip: Clip | None = None, *, with_depth: bool = True) -> Tracker:
    """Return what follows frames one by one, and knows the idle gel of a recording.

    Without depth the model is asked nothing: turns, slides and contact are measured alone.
    """
    idle, is_known = (None, True) if clip is None else (clip.background, True)
    if clip is not None and idle is None:
        idle, is_known = gel_of(scene_of(clip).steadied(clip))
    if not with_depth:
        return Tracker(idle=idle, is_contact_known=is_known)
    believe, whole = believer(bundle.model, bundle.motion), _whole(bundle, clip)
    return Tracker(believe, idle=idle, is_contact_known=is_known, whole=whole)


def _whole(bundle: Bundle, recording: Clip | None) -> Whole:
    """Return what makes the belief of a clip beside the idle gel that came with its recording."""

    def whole(clip: Clip) -> Belief:
        if recording is not None:
            clip = replace(clip, background=recording.background)
        return belief_of(bundle, perceive_clip(bundle, clip))

    return whole


def perceive_recording(
    bundle: Bundle, clip: Clip, track: Track, span: tuple[int, int] | None = None
) -> Encoded:
    """Perceive a recording that was tracked, or a span of it.

    Args:
        bundle: The model.
        clip: The recording, or those of its frames that are kept, steadied by the track's scene.
        track: Of all of it.
        span: First and last frame, both included, by their numbers.

    Raises:
        UnreadableClip: If its frames hold no picture of a gel.
        UsageError: As of `Track.between`.
    """
    started = time.perf_counter()
    clip = with_background(with_found_idle(clip))
    part = track if span is None else track.between(*span)
    # Not every frame that was tracked need be kept: the nearest shows the same.
    wanted = window_of(part)
    away = np.abs(np.subtract.outer(part.numbers[list(wanted)], clip.frame_numbers))
    nearest = away.argmin(axis=1).tolist()
    window = perceive_clip(bundle, clip.select(nearest), track.scene)
    if span is not None:
        used = f"Tracked from frame {part.numbers[0]} to {part.numbers[-1]}."
        window = replace(window, clip=window.clip.with_note(used))
    if not part.is_contact_known:
        # What was compared with is a guess, or not there.
        window = replace(window, is_contact_known=False, is_changed=False, is_faint=False)
    belief = belief_of(bundle, window)
    if len({*nearest}) < len({*wanted}):  # too few were kept to show how far it goes
        belief = replace(belief, readable=dict.fromkeys(belief.readable, True))
    part = part.as_readable(belief.readable)
    timing = window.timing_ms | {"track": 1e3 * (time.perf_counter() - started)}
    return replace(
        window,
        timing_ms=timing,
        track=part,
        recording=clip,
        believe=partial(_belief, part, belief),
        prefix_by=partial(prefix_of, bundle),
    )


def with_found_idle(clip: Clip) -> Clip:
    """Return a recording beside its idle gel, if that is given or found where nothing touches."""
    idle = None if clip.background is not None else find_idle(clip)
    return clip if idle is None else replace(clip, background=idle)


def _belief(track: Track, window: Belief, _: Encoded) -> Belief:
    return belief_of_track(track, window)


def _four(clip: Clip) -> Clip:
    """Return four frames of a clip of two to four: a, b becomes a, a, b, b; a, b, c a, b, b, c.

    Played backwards it stays exactly that.
    """
    if len(clip) == FRAME_COUNT:
        return clip
    places = np.rint(np.linspace(0, len(clip) - 1, FRAME_COUNT))
    return clip.select([int(place) for place in places])


def _nothing_seen(change_grey: float) -> str:
    return (
        f"No frame differs from the idle gel by more than {change_grey:.1f} grey levels; a touch "
        f"fainter than {UNTOUCHED_GREY:g} is not seen."
    )
