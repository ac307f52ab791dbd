"""Answers to the questions of a page: the conversation, and all that stands beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import geotlm_lm as lm

from . import stage
from .clips import LoadedClip, Reading, compared
from .conversation import exchanges, facts_of, fields_of, in_frame, suggested
from .opening import about_clip, nothing_asked, offered
from .toolkit import Filled
from .turns import SessionInTurns

MOST_OPTIONS = 5

REGION_VALUES = ("shear_change_x", "shear_change_y", "contact_mass")


@dataclass
class Talking:
    """Answers questions about a clip."""

    answerer: lm.Answerer

    def ask(
        self,
        question: str,
        shown: LoadedClip | None,
        facts: list[str],
        mm_per_px: float | None,
    ) -> Iterator[Filled]:
        """Answer the next question of the conversation, or take a fact about the recording."""
        if not question:  # the second of two clicks
            return
        if shown is None:
            raise lm.GeoTLMError("No recording is open; open one first.")
        if question in shown.refused:
            shown.refused.remove(question)
            raise lm.GeoTLMError(
                "This was asked of a recording that failed; ask again of this one."
            )
        session, size_before = shown.session, shown.session.frame.mm_per_px
        session.frame = replace(session.frame, **fields_of(facts), mm_per_px=mm_per_px or None)
        yield {"chat": exchanges(session, question), "question": ""}
        try:
            answer = session.ask(question)
        except lm.GeoTLMError:
            yield {"chat": exchanges(session), "question": question}
            raise
        if shown.second is not None and hasattr(answer, "naming"):
            answer = answer.naming(shown.source.name, shown.second.source.name)
            session.history[-1] = replace(session.history[-1], answer=answer)
        frame, stated = session.frame, facts_of(session.frame)
        seen = getattr(answer, "in_the_image", None)  # not of two recordings
        direction = None if seen is None else seen.value
        redrawn = frame.mm_per_px != size_before
        # A field that the question did not fill may have been filled meanwhile.
        is_sized = (frame.mm_per_px or 0) != (mm_per_px or 0)
        yield {
            "chat": exchanges(session),
            "last": direction,
            "frame": stated,
            **({"mm_per_px": frame.mm_per_px or 0} if is_sized else {}),
            "framed": in_frame(stated, direction),
            "chips": suggested(shown),
            **(self.redraw(shown) if redrawn else {}),
            **self.beside(answer, shown),
        }

    def wait(self, question: str, reading: Reading | None, about: Any) -> Iterator[Filled]:
        """Show that a question waits for the recording that is being read, if one is."""
        values: Filled = {}
        if question and reading is not None:
            reading.questions.append(question)
            pending = f"{question} (waiting until the recording is read)"
            values = {"chat": exchanges(self.session_of(about), pending)}
        yield values

    def again(self, about: Any, *others: Any) -> Iterator[Filled]:
        """Ask the last question of the conversation again, in its old place."""
        session = self.session_of(about)
        if session is None or not session.history:
            return
        question = session.history[-1].question
        session.take_back(question)
        for values in self.ask(question, about, *others):
            yield {name: value for name, value in values.items() if name != "question"}

    def resize(self, shown: LoadedClip | None, mm_per_px: float | None) -> Iterator[Filled]:
        """Tell lengths by another size of a pixel, in the picture as well; 0, None: in pixels."""
        size = mm_per_px or None
        if shown is None or size == shown.session.frame.mm_per_px:
            return
        shown.session.frame = replace(shown.session.frame, mm_per_px=size)
        yield self.redraw(shown) | {"chips": suggested(shown)}

    def shown_again(self, about: Any, *_: Any) -> Iterator[Filled]:
        """Show the conversation without the question that was being answered."""
        session = self.session_of(about)
        if isinstance(session, SessionInTurns):
            session.stop()
        yield {"chat": exchanges(session)}

    def session_of(self, shown: LoadedClip | None) -> Any:
        """Return the conversation; None where there is none."""
        return None if shown is None else shown.session

    def redraw(self, shown: LoadedClip) -> Filled:
        """Return what the stage shows once the size of a pixel is another."""
        return stage.stages_of(shown)

    def beside(self, answer: Any, shown: LoadedClip) -> Filled:
        """Return what an answer rests on, and the conversation as a program."""
        beside = {"code": code_of(shown), "saving": offered(shown)}
        if hasattr(answer, "relation"):  # of two recordings
            verdicts = [
                [name, _way(each.direction), each.text]
                for name, each in (("first", answer.first), ("second", answer.second))
            ]
            return beside | {"evidence": about_clip(shown) | {"verdicts": verdicts}}
        if shown.second is not None and answer.places[0]:
            shown = shown.second
        details = answer.to_dict()
        timing_ms = details.get("timing_ms", {}) | shown.opinions["timing_ms"]
        # What is to be known of the answer; the clip's own notes stand beside the clip.
        notes = [note for note in answer.notes if note not in shown.encoded.clip.notes]
        likeliest = sorted(answer.options.items(), key=lambda option: -option[1])
        evidence = about_clip(shown) | {
            "notes": notes,
            "probabilities": likeliest[:MOST_OPTIONS],
            "band": _band(self.answerer, details),
            "verdicts": _verdicts(answer, shown),
            "regions": [
                [name.replace("_", " "), *(round(values[key], 3) for key in REGION_VALUES)]
                for name, values in details.get("evidence", {}).get("regions", {}).items()
            ],
            "timing": " · ".join(f"{name} {value:.1f} ms" for name, value in timing_ms.items()),
        }
        return beside | {"evidence": evidence}

    def forget(self, shown: LoadedClip | None, facts: list[str], *_: Any) -> Iterator[Filled]:
        """Begin the conversation about the clip anew; the frame that the page shows still holds."""
        anew = None
        if shown is not None:
            anew = replace(shown, session=self.answerer.session(shown.encoded))
            anew = compared(anew, shown.second)
        yield nothing_asked(anew) | {
            "shown": anew,
            "framed": in_frame(facts, None),
            "chips": suggested(anew),
            "saving": offered(anew),
        }


def _verdicts(answer: Any, shown: LoadedClip) -> list[list[Any]]:
    """Return the motion that each method reads, all told from the answer's point of view.

    Of an answer that is no motion it is the motion that the picture shows.
    """
    probe, flow = shown.opinions["probe"], shown.opinions["optical_flow"]
    motion = answer.direction or stage.way_of(shown, answer.frame)
    fitted = (flow["rotation_deg"], flow["slide_x_px"], flow["slide_y_px"], 0.0)
    turn, right, down, _ = answer.edit.matrix @ fitted + 0.0  # 0.0 has no sign of its own
    far = lm.flow_phrase(turn, right, down)
    sure = f"{100 * probe['probability']:.0f} % (not calibrated)"
    return [
        ["answer", _way(motion), answer.text],
        ["linear probe", answer.edit.of_way(lm.Motion(probe["motion"])).value, sure],
        ["optical flow", answer.edit.of_way(lm.Motion(flow["motion"])).value, far],
    ]


def _way(direction: lm.Motion | None) -> str:
    return "-" if direction is None else direction.value


def _band(answerer: lm.Answerer, details: dict[str, Any]) -> str:
    """Return from where on an answer is told, and where this one stands."""
    threshold = answerer.bundle.calibration.contact_threshold
    share = details.get("evidence", {}).get("contact_share", 0.0)
    side = "withheld" if details.get("abstained") else "told"
    return (
        f"Contact share {share:.3f}; below {threshold:.3f} no direction is claimed, nor that "
        f"nothing touches a gel that has changed. What is less than {lm.LEAST_SURE:.0%} sure is a "
        f"guess: this answer is {side}."
    )


def code_of(shown: LoadedClip) -> str:
    """Return the program that asks the questions of a conversation about its recording.

    The files of an upload are named as their owner knows them, several images by their folder.
    """
    source, questions = shown.source, [turn.question for turn in shown.session.history]
    name = Path(source.path).name if isinstance(source.path, str) else source.name
    path = name if source.example is None else f"app/{Path(source.path).parent.name}/{name}"
    frame, usual = shown.session.frame, lm.FrameSpec()
    stated = {field.name: getattr(frame, field.name) for field in fields(frame)}
    stated = {field: value for field, value in stated.items() if value != getattr(usual, field)}
    span = "" if source.span is None else f", span={source.span}"
    second = [] if shown.second is None else [shown.second.encoded.clip.name]
    return "\n".join(
        [
            "from geotlm_lm import Answerer, FrameSpec, read_clip",
            "",
            "answerer = Answerer.load()",
            f"clip = read_clip({_arguments(path, topic=source.topic)})",
            f"frame = FrameSpec({_arguments(**stated)})",
            f"talk = answerer.session(answerer.encode(clip{span}), frame=frame)",
            *(f"talk.add_clip(answerer.encode(read_clip({name!r})))" for name in second),
            f"for question in {questions!r}:",
            "    print(talk.ask(question).text)",
        ]
    )


def _arguments(*given: Any, **named: Any) -> str:
    named = {name: value for name, value in named.items() if value is not None}
    return ", ".join([*map(repr, given), *(f"{name}={value!r}" for name, value in named.items())])
