"""The model behind one object: encode a clip once, then ask, compare and explain."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from geotlm_lm.answering.answer import Answer, Comparison, Why
from geotlm_lm.answering.argument_checks import require_answer, require_encoded, require_frame
from geotlm_lm.answering.asked import Asked
from geotlm_lm.answering.belief_of_clip import belief_of, prefix_of
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.monitor import Condition, Monitor, condition_of
from geotlm_lm.answering.perceiving import (
    perceive_clip,
    perceive_recording,
    track_recording,
    tracker_of,
    with_found_idle,
    with_idle_of,
)
from geotlm_lm.answering.pipeline import compared, respond
from geotlm_lm.answering.reasons import own_view, reasoning_steps
from geotlm_lm.answering.session import Session
from geotlm_lm.answering.understanding import understand
from geotlm_lm.checkpoint import Bundle, load_bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import Edit
from geotlm_lm.core.errors import check_question
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.language.size import SLOTS
from geotlm_lm.recordings.legible import require_any_legible
from geotlm_lm.recordings.read import frames_inside, require_motion
from geotlm_lm.recordings.scene_checks import scene_of
from geotlm_lm.track.track import Track
from geotlm_lm.track.tracker import Tracker

CAMERA = FrameSpec()
"""Directions as the camera image shows them, of the object."""


class Answerer:
    """Answers questions about clips.

    Args:
        bundle: The model.
    """

    def __init__(self, bundle: Bundle) -> None:
        self.bundle = bundle

    @classmethod
    def load(cls, folder: str | Path | None = None) -> Answerer:
        """Load a bundle from `folder`, or the one that ships with the package.

        Args:
            folder: Of the bundle.

        Raises:
            IncompatibleBundle: If there is no bundle of this format.
        """
        return cls(load_bundle(None if folder is None else Path(folder)))

    def encode(
        self,
        clip: Clip,
        *,
        span: tuple[int, int] | None = None,
        track: Track | None = None,
        progress: Progress = silent,
    ) -> Encoded:
        """Perceive a clip of up to four frames once; a longer recording is tracked.

        Args:
            clip: A recording of two frames or more.
            span: First and last frame to use, both included; None uses all.
            track: Of the recording, where it was tracked before.
            progress: As of `track`.

        Raises:
            UnreadableClip: If there is only one frame, or the frames hold no picture of a gel.
            UsageError: If the span is not inside the clip.
            TypeError: If it is no clip, such as a path, or the span is not two whole numbers.
        """
        _require_clip(clip, "encode")
        require_motion(clip)
        inside = clip if span is None else frames_inside(clip, span)
        if len(inside) <= FRAME_COUNT:
            inside = inside if span is None else with_idle_of(inside, clip)
            return perceive_clip(self.bundle, inside)
        require_any_legible(inside)  # before it is followed, which takes long
        scene = scene_of(clip) if track is None else track.scene
        # Once, for the track and for the four frames looked at.
        clip = with_found_idle(scene.steadied(clip))
        track = track_recording(self.bundle, clip, progress, scene) if track is None else track
        return perceive_recording(self.bundle, clip, track, span)

    def track(self, recording: Clip, *, progress: Progress = silent) -> Track:
        """Follow a recording from its first frame to its last: what moved when, and how far.

        Args:
            recording: Of two frames or more.
            progress: Called after each frame; it may let others have the processor.

        Raises:
            UnreadableClip: If there is only one frame.
            TypeError: If it is no clip, such as a path.
        """
        _require_clip(recording, "track")
        return track_recording(self.bundle, require_motion(recording), progress)

    def tracker(self, recording: Clip | None = None) -> Tracker:
        """Return what follows frames that are fed to it one by one; its end is a `Track`.

        Args:
            recording: That the frames are of, for its idle gel; None to learn that while nothing
                touches, as of a camera.
        """
        return tracker_of(self.bundle, recording)

    def condition(
        self, text: str, *, frame: FrameSpec = CAMERA, is_negated: bool = False
    ) -> Condition:
        """Return a condition as it is understood, before anything is seen.

        Args:
            text: Such as "it has turned 30 degrees clockwise".
            frame: In which directions are meant.
            is_negated: Whether its contrary is waited for.

        Raises:
            UsageError: If it is not surely understood, is no yes or no, or could never be told.
        """
        require_frame(frame)
        return condition_of(self.bundle, text, frame, is_negated=is_negated)

    def monitor(
        self,
        source: str | Path | None,
        condition: str | Condition,
        *,
        frame: FrameSpec = CAMERA,
        **options: Any,
    ) -> Monitor:
        """Return what watches a camera or a recording for a condition.

        Iterated, it yields the `Verdict`s at which the condition begins to hold; without a source
        frames are pushed: `monitor.push(frame, time_s, own_motion)`.

        Args:
            source: A camera's number, a device file or a recording, opened once it is iterated;
                None to push frames.
            condition: In words, or as of `condition`.
            frame: In which directions are meant.
            options: As of `Monitor`: `sure`, `lasting_s`, `whose`, `since`, `fps`.

        Raises:
            UsageError: If the condition is refused, or an option is outside its range.
        """
        if not isinstance(condition, Condition):
            condition = self.condition(condition, frame=frame)
        tracker = tracker_of(self.bundle, with_depth=condition.is_of_depth)
        return Monitor(tracker, condition, source, **options)

    def believing(self, encoded: Encoded) -> Encoded:
        """Return a clip with what makes its belief, and what shows it to the language model.

        One that somebody else has perceived has neither.
        """
        require_encoded(encoded)
        if encoded.believe is None:
            encoded = replace(encoded, believe=partial(belief_of, self.bundle))
        if encoded.prefix_by is None:
            encoded = replace(encoded, prefix_by=partial(prefix_of, self.bundle))
        return encoded

    def session(self, encoded: Encoded, frame: FrameSpec = CAMERA) -> Session:
        """Return a conversation about a clip, which remembers its turns and the frame.

        Raises:
            TypeError: If the clip is not encoded, or the frame is none.
        """
        return Session(self, encoded, frame)

    def ask(self, encoded: Encoded, question: str, *, frame: FrameSpec = CAMERA) -> Answer:
        """Answer `question` about an encoded clip.

        Facts that the question states ("The image is mirrored. Which way?") hold for it.

        Args:
            encoded: The clip.
            question: In English; a fact about the frame alone is noted.
            frame: In which to tell directions.

        Raises:
            UsageError: If the question is empty or too long.
            TypeError: If the clip is not encoded, the question no text, or the frame none.
        """
        encoded = self.believing(encoded)
        require_frame(frame)
        return respond(Asked(self.bundle, (encoded,), frame), check_question(question))

    def compare(
        self,
        first: Encoded,
        second: Encoded,
        question: str = "Do they go the same way?",
        *,
        frame: FrameSpec = CAMERA,
    ) -> Comparison:
        """Answer a question about two clips: whether they go the same way, which goes further.

        Which way one of them goes, "the second one", is told as well.

        Raises:
            UsageError: If the question is empty or too long.
            TypeError: If a clip is not encoded, the question no text, or the frame none.
        """
        require_frame(frame)
        asked = Asked(self.bundle, (self.believing(first), self.believing(second)), frame)
        typed = check_question(question)
        return compared(asked, understand(self.bundle.reader, typed, None, asked))

    def why(self, encoded: Encoded, answer: Answer) -> Why:
        """Return the reasons for `answer`, by rule from the geometry, and the model's own view.

        Raises:
            TypeError: If the clip is not encoded, or the answer is none about one clip.
        """
        encoded = self.believing(encoded)
        require_answer(answer)
        motion = answer.in_the_image
        is_as_seen = answer.edit == Edit()
        place, *steps, conclusion = reasoning_steps(
            answer.evidence, answer.text, motion, is_as_seen=is_as_seen
        )
        frame = f"The answer is told in this frame: {answer.frame.summary()}."
        measured = [] if answer.motion is None else [answer.motion.sentence()]
        source = "by rule, from the geometry the model read"
        own = self._own_view(encoded, answer)
        return Why((place, *steps, *measured, *own, frame, conclusion), source)

    def _own_view(self, encoded: Encoded, answer: Answer) -> list[str]:
        """Return what the language model itself makes of what it was asked, where it was asked."""
        if not answer.written or not encoded.prefix.slots:
            return []
        speaker, calibration = self.bundle.speaker, self.bundle.calibration
        shares = {
            slot: dict(zip(SLOTS[slot], calibration.slot_probabilities(each), strict=True))
            for slot, each in encoded.prefix.slots.items()
        }
        is_same = answer.told_by == "model"
        asked = answer.question, answer.written
        sentence = "" if is_same else speaker.sentence(encoded.prefix, *asked, answer.text)
        return [own_view(shares, sentence, is_same=is_same)]


def _require_clip(clip: object, what: str) -> None:
    if not isinstance(clip, Clip):
        raise TypeError(
            f"{what} takes a Clip, found {type(clip).__name__}; read a file by "
            f"read_clip(path), or make one of an array by Clip(frames)"
        )
