"""The same answers for programs and agents: typed functions, each a tool."""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

import geotlm_lm as lm

from . import schema as p
from .clips import LoadedClip, OpenedRecordings
from .guards import EVENTS
from .simulate_tab import simulate as simulate_and_ask
from .sources import Sources
from .turns import LISTENER

SHORT_ANSWER = ("text", "decided", "abstained", "confidence", "amount", "direction", "query")
"""Fields of an answer without details."""

SAME_WAY = "Do they go the same way?"


class Api:
    """The functions programs call; each is documented where it is served."""

    def __init__(self, answerer: lm.Answerer, sources: Sources) -> None:
        self._answerer, self._sources = answerer, sources
        self._opened = OpenedRecordings(answerer, sources)

    @property
    def functions(self) -> tuple[Callable[..., Any], ...]:
        """All of them."""
        return (
            *(self.recordings, self.ask, self.track, self.wait_until, self.compare),
            *(self.simulate, self.evidence, self.picture),
        )

    def recordings(self) -> p.Listing:
        """List the recordings and examples that other tools take by name, with kind and length."""
        return self._sources.listing()

    def ask(
        self,
        recording: p.Recording,
        question: p.Question,
        frames: p.Frames = None,
        frame: p.Frame = p.AS_RECORDED,
        topic: p.Topic = None,
        details: p.Details = False,
    ) -> p.AnswerResult:
        """Answer a question about how the touched object in a recording moves.

        Returns the words, the decision, the calibrated confidence, an amount with its span, the
        direction as the frame of reference tells it, and how the question was read; with `details`
        also what it rests on.
        """
        shown = self._opened.open(recording, frames, topic)
        answer = self._answerer.ask(shown.encoded, question, frame=frame.spec).to_dict()
        return answer if details else {name: answer[name] for name in SHORT_ANSWER}

    def track(
        self,
        recording: p.Recording,
        frames: p.Frames = None,
        frame: p.Frame = p.AS_RECORDED,
        rows: p.Rows = 0,
        topic: p.Topic = None,
    ) -> p.TrackResult:
        """Tell what happens in a recording: events with begin, end, way, amount and probability.

        Returns also what it comes to, net and there and back, when something touches, and notes;
        numbers of single frames only where `rows` asks for them.
        """
        whole, track = self._tracked(recording, frames, topic)
        return summary_of(track, whole, frame.spec, rows)

    def wait_until(
        self,
        recording: p.Recording,
        condition: p.Condition,
        sure: p.Sure = 0.95,
        lasting_s: p.LastingS = 0.0,
        most_s: p.MostS = 60.0,
        frame: p.Frame = p.AS_RECORDED,
        topic: p.Topic = None,
    ) -> p.Waited:
        """Tell from when on a condition holds in a recording, looking at no later frame.

        Returns whether and when it holds, how sure that is, what it rests on, and how the condition
        was read; a condition that is not surely understood is refused.
        """
        understood = self._answerer.condition(condition, frame=frame.spec)
        clip, report = self._opened.whole(recording, topic).recording, LISTENER.get()
        options = {"sure": sure, "lasting_s": lasting_s, "fps": clip.fps}
        monitor = lm.Monitor(self._answerer.tracker(clip), understood, **options)
        waited: dict[str, Any] = {"holds": False}
        for number, image in zip(clip.frame_numbers, clip.frames, strict=True):
            time_s = clip.second_of(number, lm.DEFAULT_FPS)
            if time_s > most_s:
                break
            verdict = monitor.push(image, time_s, number=number)
            if verdict.holds:
                waited = verdict.to_dict()
                break
            if report is not None:
                report(f"waiting until {understood.restated}", number, clip.recorded_frames)
        return waited | {"read_as": understood.restated, "understood": understood.probability}

    def compare(
        self,
        first: p.Recording,
        second: p.Recording,
        question: p.Question = SAME_WAY,
        first_frames: p.Frames = None,
        second_frames: p.Frames = None,
        frame: p.Frame = p.AS_RECORDED,
        first_topic: p.Topic = None,
        second_topic: p.Topic = None,
    ) -> p.ComparisonResult:
        """Tell whether the objects in two recordings move the same way, or answer about both.

        Returns the relation (same, opposite, different or unknown), in words too, and both answers.
        """
        shown = [
            self._opened.open(first, first_frames, first_topic),
            self._opened.open(second, second_frames, second_topic),
        ]
        clips = [clip.encoded for clip in shown]
        return self._answerer.compare(*clips, question, frame=frame.spec).to_dict()

    def simulate(self, touch: p.SimulatedTouch = p.KEY_AT_REST) -> p.SimulatedAnswer:
        """Simulate a touch of a GelSight-like sensor and answer about it; motions may be mixed.

        Returns which way it goes and how far, in words; the true motion, which components count,
        the true amounts, the ones that were read, and their error.
        """
        return simulate_and_ask(self._answerer, lm.Touch(**touch.model_dump())).facts

    def evidence(
        self, recording: p.Recording, frames: p.Frames = None, topic: p.Topic = None
    ) -> p.EvidenceFields:
        """Return the geometry a recording's answers rest on, without a question.

        Returns contact, shear change of seven regions and of each patch; x right, y down, unitless.
        """
        shown = self._opened.open(recording, frames, topic)
        return lm.regions_of(shown.encoded) | {
            "shear_change": shown.seen.shear_change.round(4).tolist(),
            "contact_mask": shown.seen.mask.round(4).tolist(),
            "frames_used": list(shown.encoded.clip.frame_numbers),
            "second_opinions": shown.opinions,
        }

    def picture(
        self,
        recording: p.Recording,
        shows: p.Picture = "overlay",
        frames: p.Frames = None,
        mm_per_px: p.MmPerPx = None,
        topic: p.Topic = None,
    ) -> p.PictureResult:
        """Draw a recording: four frames with how far each has moved, or a track over time.

        Directions are those of the recorded image. Returns a PNG.
        """
        whole, track = self._tracked(recording, frames, topic)
        if shows == "timeline":
            options = {"in_frames": not whole.is_timed, "title": whole.name}
            png = lm.plot_png(lm.Exported(track, mm_per_px), **options)
            return _pictured(png, f"{whole.name}: turn, slide, depth, contact and grip over time")
        shown = self._opened.open(recording, frames, topic)
        numbers = ", ".join(str(number) for number in shown.encoded.clip.frame_numbers)
        return _pictured(
            _sheet(shown, shows, whole, track),
            f"{shown.encoded.clip.name}: {shows}, frames {numbers}",
        )

    def _tracked(self, given: str, frames: list[int] | None, topic: str | None) -> tuple[Any, Any]:
        """Return a recording and the track of it, or of a span."""
        opened = self._opened.whole(given, topic)
        track = opened.shown.encoded.track
        if track is None:  # of four frames or fewer, which questions look at together
            track = self._answerer.track(opened.recording)
        if frames is None:
            return opened.recording, track
        return opened.recording, track.between(*frames)


def _sheet(shown: LoadedClip, view: str, whole: Any, track: Any) -> bytes:
    """Return the four frames in one picture, two by two, each with its time, as a PNG."""
    numbers, drawn = shown.encoded.clip.frame_numbers, []
    path, first = track.path_from_start, _place_of(track, numbers[0])
    for place, number in enumerate([*numbers, *numbers[-1:] * 4][:4]):
        name = {"overlay": "raw", "shear": "arrows"}.get(view, view)
        image = lm.picture(shown.seen, name, min(place, len(numbers) - 1))
        if view == "overlay":
            way = path[_place_of(track, number)] - path[first]
            image = lm.draw_motion(image, shown.seen, *way[:3])
        time_s = f"{whole.second_of(number, lm.DEFAULT_FPS):.2f} s, " if whole.is_timed else ""
        drawn.append(lm.draw_caption(image, f"{time_s}frame {number}"))
    sheet = cv2.vconcat([cv2.hconcat(drawn[:2]), cv2.hconcat(drawn[2:])])
    return cv2.imencode(".png", cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))[1].tobytes()


def _place_of(track: Any, number: int) -> int:
    """Return which tracked frame is nearest: repeated ones are left out."""
    return int(np.abs(track.numbers - number).argmin())


def _pictured(png: bytes, shows: str) -> p.PictureResult:
    rows_at, columns_at = slice(20, 24), slice(16, 20)  # in the file's first chunk
    return {
        "shows": shows,
        "mime_type": "image/png",
        "width_px": int.from_bytes(png[columns_at]),
        "height_px": int.from_bytes(png[rows_at]),
        "png_base64": base64.b64encode(png).decode(),
    }


def summary_of(track: Any, recording: Any, frame: lm.FrameSpec, rows: int) -> p.TrackResult:
    """Return what the track of a recording, or of a span, comes to; so many rows at most."""
    exported, edit = lm.Exported(track, frame.mm_per_px), frame.edit
    facts = exported.to_dict()
    return {
        "recording": recording.name,
        "frame": frame.summary(),
        "first_frame": int(track.numbers[0]),
        "last_frame": int(track.numbers[-1]),
        "times_are_known": recording.is_timed,
        "contacts_s": [[round(end, 4) for end in ends] for ends in track.contacts()],
        "events": [_event_seen(event, edit) for event in facts["events"][:EVENTS]],
        "events_left_out": max(len(facts["events"]) - EVENTS, 0),
        "totals": _totals_seen(facts["totals"], edit),
        "rows": [_row_seen(row, exported.units.name, edit) for row in _spread(exported, rows)],
        "notes": [*recording.notes, *facts["notes"]],
    }


def _event_seen(event: dict[str, Any], edit: Any) -> dict[str, Any]:
    way = None if event["way"] is None else edit.of_way(lm.Motion(event["way"])).value
    if (event.get("amount") or 0.0) < 0:  # amounts are how far it goes the way that is named
        event |= _negated(event)
    return event | {"way": way}


def _totals_seen(totals: dict[str, Any], edit: Any) -> dict[str, Any]:
    net, way = totals["turn_net"], (totals["slide_right"], totals["slide_down"])
    if net["amount"] is not None and edit.matrix[0, 0] < 0:
        totals = totals | {"turn_net": net | _negated(net)}
    if None in way:  # the pictures do not tell how far
        return totals
    right, down = edit.matrix[1:3, 1:3] @ way + 0.0
    return totals | {"slide_right": float(right), "slide_down": float(down)}


def _row_seen(row: dict[str, Any], unit: str, edit: Any) -> dict[str, float]:
    names, slide = [f"right_{unit}", f"down_{unit}"], edit.matrix[1:3, 1:3]
    deviations = [f"{name}_deviation" for name in names]
    way = slide @ [row[name] for name in names] + 0.0
    values = [*way, *np.abs(slide) @ [row[name] for name in deviations]]
    turn = {"turn_deg": float(edit.matrix[0, 0] * row["turn_deg"] + 0.0)}
    return row | turn | dict(zip([*names, *deviations], map(float, values), strict=True))


def _negated(span: dict[str, Any]) -> dict[str, float]:
    return {"amount": -span["amount"], "low": -span["high"], "high": -span["low"]}


def _spread(exported: lm.Exported, most: int) -> list[dict[str, Any]]:
    """Return at most so many frames, the first and the last among them."""
    rows = list(exported.rows()) if most else []
    if len(rows) <= most:
        return rows
    return [rows[place] for place in np.linspace(0, len(rows) - 1, most).round().astype(int)]
