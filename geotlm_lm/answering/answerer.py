"""The model behind one object: encode a clip once, then ask, compare and explain."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from geotlm_lm.answering.answer import Answer, Comparison, Why
from geotlm_lm.answering.encoded import Encoded, require
from geotlm_lm.answering.monitor import Condition, Monitor, condition_of
from geotlm_lm.answering.perceiving import (
    belief_of,
    perceive_clip,
    perceive_recording,
    prefix_of,
    track_recording,
    tracker_of,
    with_found_idle,
)
from geotlm_lm.answering.pipeline import answer, compared
from geotlm_lm.answering.reasons import own_view, reasoning_steps, times_step
from geotlm_lm.answering.understanding import Asked, Understood, is_sound, understand, with_waiting
from geotlm_lm.checkpoint import Bundle, load_bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import Edit
from geotlm_lm.core.errors import check_question
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.twist import Component
from geotlm_lm.language.size import SLOTS
from geotlm_lm.query.phrases import unit_phrase
from geotlm_lm.query.program import Program, asks_of_two, head_of, type_of
from geotlm_lm.recordings.legible import require_any_legible
from geotlm_lm.recordings.read import frames_inside, require_motion
from geotlm_lm.recordings.scene_checks import scene_of
from geotlm_lm.track.track import Track
from geotlm_lm.track.tracker import Follow, Tracker, unfollowed

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
        follow: Follow = unfollowed,
    ) -> Encoded:
        """Perceive a clip of up to four frames once; a longer recording is tracked.

        Args:
            clip: A recording of two frames or more.
            span: First and last frame to use, both included; None uses all.
            track: Of the recording, where it was tracked before.
            progress: As of `track`.
            follow: Called with the tracker after each frame of a recording that is tracked; once it
                returns True, the rest is left out.

        Raises:
            UnreadableClip: If there is only one frame, or the frames hold no picture of a gel.
            UsageError: If the span is not inside the clip.
            TypeError: If it is no clip, such as a path, or the span is not two whole numbers.
        """
        _require_clip(clip, "encode")
        require_motion(clip)
        inside = clip if span is None else frames_inside(clip, span)
        if len(inside) <= FRAME_COUNT:
            if span is not None:
                inside = replace(inside, background=with_found_idle(clip).background)
            return perceive_clip(self.bundle, inside)
        require_any_legible(inside)  # before it is followed, which takes long
        scene = scene_of(clip) if track is None else track.scene
        # Once, for the track and for the four frames looked at.
        clip = with_found_idle(scene.steadied(clip))
        if track is None:
            track = track_recording(self.bundle, clip, progress, scene, follow)
            if span is not None:
                span = span[0], min(span[1], int(track.numbers[-1]))
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
        track = track_recording(self.bundle, require_motion(recording), progress)
        return self.seen_closely(recording, track)

    def seen_closely(self, recording: Clip, track: Track) -> Track:
        """Return a track with events that say whether the pictures tell how far they go.

        Four frames of the main event are looked at for this, as for an answer; a track of four
        frames or fewer says so already.
        """
        moves = track.of(Component.TURN) or track.of(Component.SLIDE)
        if len(track) <= FRAME_COUNT or not moves:
            return track
        return self.encode(recording, track=track).track

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
        require(frame, FrameSpec)
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
        require(encoded, Encoded)
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
        require(frame, FrameSpec)
        asked = Asked(self.bundle, (encoded,), frame)
        return answer(asked, understand(self.bundle.reader, check_question(question), None, asked))

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
        require(frame, FrameSpec)
        asked = Asked(self.bundle, (self.believing(first), self.believing(second)), frame)
        typed = check_question(question)
        return compared(asked, understand(self.bundle.reader, typed, None, asked))

    def why(self, encoded: Encoded, answer: Answer) -> Why:
        """Return the reasons for `answer`, by rule from the geometry, and the model's own view.

        Raises:
            TypeError: If the clip is not encoded, or the answer is none about one clip.
        """
        encoded = self.believing(encoded)
        require(answer, Answer)
        motion = answer.in_the_image
        is_as_seen = answer.edit == Edit()
        place, *steps, conclusion = reasoning_steps(
            answer.evidence, answer.text, motion, is_as_seen=is_as_seen
        )
        frame = f"The answer is told in this frame: {answer.frame.summary()}."
        measured = [] if answer.motion is None else [answer.motion.sentence()]
        source = "by rule, from the geometry the model read"
        times = times_step(answer.values, encoded.evidence_by(0), answer.frame)
        own = self._own_view(encoded, answer, is_of_time=bool(times))
        events = [times] if times else []
        return Why((place, *steps, *measured, *events, *own, frame, conclusion), source)

    def _own_view(self, encoded: Encoded, answer: Answer, *, is_of_time: bool) -> list[str]:
        """Return what the language model itself makes of what it was asked, where it was asked.

        Of times it is not quoted: it is shown four frames, and no recording.
        """
        if not answer.written or not encoded.prefix.slots:
            return []
        speaker, calibration = self.bundle.speaker, self.bundle.calibration
        shares = {
            slot: dict(zip(SLOTS[slot], calibration.slot_probabilities(each), strict=True))
            for slot, each in encoded.prefix.slots.items()
        }
        is_same = answer.told_by == "model"
        asked = answer.question, answer.written
        is_quoted = not (is_same or is_of_time)
        sentence = speaker.sentence(encoded.prefix, *asked, answer.text) if is_quoted else ""
        return [own_view(shares, sentence, is_same=is_same)]


Reply = Answer | Comparison
_ASIDE = ("fact", "talk")
"""Kinds of answers that are about no clip."""


@dataclass(frozen=True)
class Turn:
    """One question and its answer.

    Args:
        question: As it was asked.
        answer: What was said to it.
        frame: The frame of reference before it.
        encoded: The clip that questions were about; None where it has grown and others were asked
            since, of which each would keep its own frames.
        before: What was asked before it.
        named: The point of view that had been named by then.
        place: Of the clip in the conversation, from 0.
        is_sound: Whether what was asked could be answered of some recording.
    """

    question: str
    answer: Reply
    frame: FrameSpec
    encoded: Encoded | None
    before: Program
    named: str | None
    place: int
    is_sound: bool = True


class Session:
    """A conversation.

    Args:
        answerer: The model.
        encoded: The clip it begins with.
        frame: The frame of reference it begins with.

    Raises:
        TypeError: If the clip is not encoded, or the frame is none.
    """

    def __init__(self, answerer: Answerer, encoded: Encoded, frame: FrameSpec) -> None:
        require(encoded, Encoded)
        require(frame, FrameSpec)
        self.answerer = answerer
        self.clips = [answerer.believing(encoded)]
        self.frame = frame
        self.history: list[Turn] = []
        self._before = Program()
        self._named: str | None = None

    @property
    def encoded(self) -> Encoded:
        """The clip that questions are about: the last one given."""
        return self.clips[-1]

    @property
    def last(self) -> Reply | None:
        """The last answer about a clip: neither talk nor a fact, nor of what makes no sense."""
        turn = self._last_turn
        return None if turn is None else turn.answer

    @property
    def _last_turn(self) -> Turn | None:
        turns = (turn for turn in reversed(self.history) if turn.answer.kind not in _ASIDE)
        return next((turn for turn in turns if turn.is_sound), None)

    def add_clip(self, encoded: Encoded) -> None:
        """Make another clip the one that questions are about; comparisons look back at the last.

        The size of a pixel that was told holds for frames of the same size only, a frame rate for
        clips whose files tell none.

        Raises:
            TypeError: If it is not encoded.
        """
        require(encoded, Encoded)
        if encoded.clip.frames.shape[1:3] != self.encoded.clip.frames.shape[1:3]:
            self.frame = replace(self.frame, mm_per_px=None)
        if encoded.clip.fps is not None:
            self.frame = replace(self.frame, rate_hz=None)
        self.clips.append(self.answerer.believing(encoded))
        self._named = None

    def grow(self, encoded: Encoded) -> None:
        """Take a clip for the last one with more frames, as of a camera that goes on.

        What refers to the last answer ("are you sure?") is about what was seen by then.

        Raises:
            TypeError: If it is not encoded.
        """
        require(encoded, Encoded)
        self.clips[-1] = self.answerer.believing(encoded)
        last = self._last_turn
        self.history = [
            turn if turn is last else replace(turn, encoded=None) for turn in self.history
        ]

    def ask(self, question: str) -> Reply:
        """Answer the next question.

        Args:
            question: In English, or a fact about the recording.

        Raises:
            UsageError: If the question is empty or too long.
        """
        typed = check_question(question)
        clips = tuple(self.clips[-2:])
        asked = Asked(self.answerer.bundle, clips, self.frame, self._named)
        understood = understand(asked.bundle.reader, typed, self._before, asked)
        sure = getattr(self.last, "understood", 1.0)
        understood = with_waiting(understood, self._before, sure, asked)
        about_last = self._about_last(understood)
        if about_last is not None:
            reply: Reply = about_last
        elif len(clips) == 2 and any(map(asks_of_two, understood.program.answers)):
            reply = compared(asked, understood)
        else:
            reply = answer(asked, understood)
        place, sound = len(self.clips) - 1, is_sound(asked.values(understood.program))
        turn = Turn(typed, reply, self.frame, self.encoded, self._before, self._named, place, sound)
        self.history.append(turn)
        if isinstance(reply, Answer):
            self._named = reply.point_of_view or self._named
        if understood.ask_back is None:
            self.frame = asked.frame_after(understood.program)
            # "Thanks" and "why?" are nothing that a follow-up leans on, nor is what makes no sense.
            if sound and any(
                type_of(head_of(each)) != "talk" for each in understood.program.answers
            ):
                self._before = understood.program
        return reply

    def _about_last(self, understood: Understood) -> Answer | None:
        """Return what is told of the last answer about this clip: how sure, how near, and why."""
        turn = self._last_turn
        if turn is None or turn.place != len(self.clips) - 1 or understood.ask_back is not None:
            return None
        last, asked = turn.answer, understood.program.answers
        if not isinstance(last, Answer) or len(asked) != 1 or understood.program.form != "sentence":
            return None
        word = asked[0].word
        if word == "why":
            text = " ".join(self.answerer.why(turn.encoded or self.encoded, last).steps)
        elif word == "sure-amount" and last.amount is not None:
            low, high = last.amount.span
            text = f"Nine times in ten it is {low:g} to {high:g}{unit_phrase(last.amount)}."
        elif word in ("sure", "sure-amount"):
            inside = f"{last.text[:1].lower()}{last.text[1:]}"
            text = last.text if last.abstained else f"About {last.confidence:.0%}: {inside}"
        else:
            return None
        return replace(last, text=text, kind="talk", query=understood.line)

    def take_back(self, question: str) -> None:
        """Forget the last turn, if this was its question, and what it said about the frame."""
        if self.history and self.history[-1].question == check_question(question):
            turn = self.history.pop()
            self.frame, self._before, self._named = turn.frame, turn.before, turn.named

    def to_dict(self) -> list[dict[str, Any]]:
        """Return the turns as plain JSON values."""
        return [
            {"question": turn.question, "answer": turn.answer.to_dict()} for turn in self.history
        ]


def _require_clip(clip: object, what: str) -> None:
    if not isinstance(clip, Clip):
        raise TypeError(
            f"{what} takes a Clip, found {type(clip).__name__}; read a file by "
            f"read_clip(path), or make one of an array by Clip(frames)"
        )


@lru_cache(maxsize=1)
def loaded(model: Path | None) -> Answerer:
    """Return the answerer of a bundle; arguments and errors are those of `Answerer.load`."""
    return Answerer.load(model)
