"""A clip as it was perceived, from which every answer about it starts; runs no model."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geotlm_lm.backbone.view import View
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.model import Perception, contact_centre
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.evaluate import ContactArea, Evidence
from geotlm_lm.query.speaker import TactilePrefix
from geotlm_lm.query.values import Recording
from geotlm_lm.query.worlds import worlds_of_clip, worlds_of_track
from geotlm_lm.recordings.idle import estimate_background
from geotlm_lm.track.track import Track

CUT_OFF_DOUBT = 1.5
"""Of an imprint of which a part is out of the image. Of 66 simulated clips of training objects,
moved to the border until they were cut off, 0.79 were told right at a mean probability of 0.90;
1.5 times the temperature makes that 0.78."""

FAINT_DOUBT = 1.5
"""Of what hardly changes the gel. Of 110 simulated clips faded so far to a tenth or a twentieth of
their contrast 71 are told, 0.77 of them right at a mean probability of 0.76; without the doubt 86,
0.79 of them right at 0.86."""


@dataclass(frozen=True, eq=False)
class Encoded:
    """A clip the model has perceived; every question about it starts here.

    Args:
        clip: The four frames that were used, with the background they were compared with.
        perception: Tokens and geometry, batch of one.
        timing_ms: Milliseconds of each stage that ran.
        is_untouched: Whether every frame differs from the background by less than any touch does;
            what is perceived is then the background itself.
        is_changed: Whether some frame differs from the idle gel by more than noise, codecs and
            lamps make it: that nothing touches may then not be claimed. Not known, and False, where
            the background is a guess.
        is_faint: Whether some frame differs by more than noise, but no more than codecs and lamps
            may make it; likewise.
        is_cut_off: Whether the border of the image cuts through the imprint; likewise.
        is_static: Whether the background is a guess and no frame differs from the first by more
            than an untouched gel may: a touch held still and no touch then look alike.
        is_contact_known: Whether the idle gel is known, or the gel is plain enough to be guessed:
            against a guess that lacks the gel's dots nothing tells a touch from none, nor a press
            from a release.
        suspicion: Why the pictures are probably no gel's, one sentence; "" of a gel.
        track: The track of the recording, or of the span of it that is asked about; None where four
            frames are all there is. The clip then holds the four that show its motion best.
        recording: What was tracked, whole.
        believe: What makes the belief of its motion, once, when first asked for.
        prefix_by: What shows it to the language model, likewise.
    """

    clip: Clip
    perception: Perception
    timing_ms: dict[str, float]
    is_untouched: bool = False
    is_changed: bool = False
    is_faint: bool = False
    is_cut_off: bool = False
    is_static: bool = False
    is_contact_known: bool = True
    suspicion: str = ""
    track: Track | None = None
    recording: Clip | None = None
    believe: Callable[[Encoded], Belief] | None = None
    prefix_by: Callable[[Encoded], TactilePrefix] | None = None

    @property
    def view(self) -> View | None:
        """The square of the image that the geometry's grid covers; None where it is no square."""
        return self.perception.views[0]

    @cached_property
    def belief(self) -> Belief:
        """What is believed of its motion: every answer about it starts from this one value."""
        if self.believe is None:
            raise ValueError("nothing makes a belief of this clip; encode it by an Answerer")
        return self.believe(self)

    @cached_property
    def _evidence(self) -> dict[int, Evidence]:
        return {}

    def evidence_by(self, seed: int = 0) -> Evidence:
        """Return what answers about it rest on, the same for each question.

        Args:
            seed: Of its possible worlds; clips that are compared have different ones.
        """
        if seed not in self._evidence:
            track, belief = self.track, self.belief
            worlds = (
                worlds_of_clip(belief, seed)
                if track is None
                else worlds_of_track(track, belief, seed)
            )
            self._evidence[seed] = Evidence(worlds, recording_of(self), _area(self))
        return self._evidence[seed]

    @cached_property
    def prefix(self) -> TactilePrefix:
        """How the language model sees it: all it says itself starts from this one value."""
        if self.prefix_by is None:
            raise ValueError("no language model sees this clip; encode it by an Answerer")
        return self.prefix_by(self)

    @property
    def doubt(self) -> float:
        """What multiplies the temperature of every probability."""
        return max(CUT_OFF_DOUBT if self.is_cut_off else 1.0, FAINT_DOUBT if self.is_faint else 1.0)

    @cached_property
    def regions(self) -> dict[str, Any]:
        """The geometry an answer rests on, as plain values that nobody may change."""
        geometry = self.perception.geometry
        descriptor = geometry.descriptor[0].view(2, len(REGIONS)).tolist()
        mass = geometry.region_mass[0].tolist()
        regions = {
            name: {
                "shear_change_x": round(descriptor[0][column], 4),
                "shear_change_y": round(descriptor[1][column], 4),
                "contact_mass": round(mass[column], 4),
            }
            for column, name in enumerate(REGIONS)
        }
        view = self.view and {name: round(px, 1) for name, px in asdict(self.view).items()}
        centre = None
        if self.view and not self.is_untouched:
            size = self.clip.frames.shape[1:3]
            centre = [round(px, 1) for px in contact_centre(geometry, self.view, size)]
        return {
            "contact_share": round(self.contact_share, 4),
            "contact_centre_px": centre,
            "view": view,
            "regions": regions,
        }

    @property
    def contact_share(self) -> float:
        """Mean of the contact mask over the view, in [0, 1]."""
        return float(self.perception.geometry.region_mass[0, REGIONS.index("global")])


_EXPECTED = {
    "Encoded": "an encoded clip was expected, found {}; encode it first, by "
    "answerer.encode(read_clip(path)) or answerer.encode(Clip(frames))",
    "FrameSpec": "a frame is a FrameSpec, found {}; give for example FrameSpec(viewpoint='object'),"
    " or leave it out",
    "Answer": "reasons are given for an Answer, found {}; pass on what "
    "answerer.ask(encoded, question) returns",
}


def require(argument: object, kind: type) -> None:
    """Refuse an argument of another kind in one clear sentence.

    Raises:
        TypeError: If it is of another kind.
    """
    if not isinstance(argument, kind):
        raise TypeError(_EXPECTED[kind.__name__].format(type(argument).__name__))


def with_background(clip: Clip) -> Clip:
    """Return a clip beside its idle gel, estimated where it is not known."""
    if clip.background is None:
        clip = replace(clip, background=estimate_background(clip.frames)).with_note(
            "Background: estimated from the frames; give an idle frame for a surer answer."
        )
    return clip


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


def _area(encoded: Encoded) -> ContactArea | None:
    """Return where the image is touched; None where nothing touches, or the grid is no square."""
    view, centre = encoded.view, encoded.regions["contact_centre_px"]
    if view is None or centre is None:
        return None
    rows, columns = encoded.clip.frames.shape[1:3]
    picture = view.picture_height_px * view.picture_width_px
    share = min(encoded.regions["contact_share"] * view.side_px**2 / picture, 1.0)
    return ContactArea(centre[0] / columns, centre[1] / rows, share)
