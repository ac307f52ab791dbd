"""Answers to the questions of a page: the conversation, and all that stands beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from html import escape, unescape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import FrameSpec, GeoTLMError, Motion

from . import stage
from .clips import LoadedClip
from .conversation import facts_of, fields_of, in_frame, suggested
from .opening import NOTHING_ASKED, Source, offered
from .toolkit import Filled, literal

if TYPE_CHECKING:
    from geotlm_lm import Answerer

Messages = list[dict[str, Any]]


def _whole(shown: LoadedClip, source: Source) -> dict[str, Any]:
    return stage.stage_of(shown, source.name, shown.session.frame)


def evidence_and_code(answerer: Answerer, answer: Any, shown: LoadedClip, source: Source) -> Filled:
    """Return what an answer rests on, and the conversation as a program."""
    details = answer.to_dict()
    timing_ms = details.get("timing_ms", {}) | shown.opinions["timing_ms"]
    # What is to be known of the answer; the clip's own notes stand beside the clip.
    notes = [note for note in answer.notes if note not in shown.encoded.clip.notes]
    return {
        "notes": literal("\n".join(f"- {note}" for note in notes)),
        "probabilities": dict(answer.options),
        "band": _band(answerer, details),
        "verdicts": _verdicts(answer, details, shown.opinions),
        "regions": [
            [name.replace("_", " "), *(values[key] for key in REGION_VALUES)]
            for name, values in details.get("evidence", {}).get("regions", {}).items()
        ],
        "timing": " · ".join(f"{name} {value:.1f} ms" for name, value in timing_ms.items()),
        "code": code_of(source, [turn.question for turn in shown.session.history], shown),
        "saving": offered(shown, source.example),
    }


REGION_VALUES = ("shear_change_x", "shear_change_y", "contact_mass")


@dataclass
class Talking:
    """Answers questions about a clip."""

    answerer: Answerer
    # What the stage shows once the size of a pixel is another, what else an answer fills.
    redraw: Callable[[LoadedClip, Source], dict[str, Any]] = _whole
    beside: Callable[..., Filled] = evidence_and_code

    def ask(
        self,
        question: str,
        chat: Messages,
        shown: LoadedClip | None,
        source: Source | None,
        facts: list[str],
        mm_per_px: float | None,
    ) -> Iterator[Filled]:
        """Answer the next question of the conversation, or take a fact about the recording."""
        if shown is None:
            raise GeoTLMError("No recording is open; upload a clip first.")
        session, size_before = shown.session, shown.session.frame.mm_per_px
        session.frame = replace(session.frame, **fields_of(facts), mm_per_px=mm_per_px or None)
        answer = session.ask(question)
        frame, stated = session.frame, facts_of(session.frame)
        direction = None if answer.in_the_image is None else answer.in_the_image.value
        redrawn = frame.mm_per_px != size_before
        yield {
            "chat": [
                *(chat or []),
                {"role": "user", "content": escape(question, quote=False)},
                {"role": "assistant", "content": escape(_sentence(answer), quote=False)},
            ],
            "question": "",
            "last": direction,
            "frame": stated,
            "mm_per_px": frame.mm_per_px or 0,
            "framed": in_frame(stated, direction),
            "chips": suggested(shown),
            **({"stage": self.redraw(shown, source)} if redrawn else {}),
            **self.beside(self.answerer, answer, shown, source),
        }

    def again(self, chat: Messages, shown: LoadedClip | None, *others: Any) -> Iterator[Filled]:
        """Ask the last question of the conversation again, in its old place."""
        asked = [place for place, message in enumerate(chat or []) if message["role"] == "user"]
        if not asked:
            return
        question = text_of(chat[asked[-1]])
        if shown is not None:
            shown.session.take_back(question)
        for values in self.ask(question, chat[: asked[-1]], shown, *others):
            yield {name: value for name, value in values.items() if name != "question"}

    def resize(
        self, shown: LoadedClip | None, source: Source | None, mm_per_px: float | None
    ) -> Iterator[Filled]:
        """Tell lengths by another size of a pixel, in the picture as well; 0, None: in pixels."""
        size = mm_per_px or None
        if shown is None or size == shown.session.frame.mm_per_px:
            return
        shown.session.frame = replace(shown.session.frame, mm_per_px=size)
        yield {"stage": self.redraw(shown, source), "chips": suggested(shown)}

    def forget(
        self, shown: LoadedClip | None, source: Source | None, facts: list[str], *_: Any
    ) -> Iterator[Filled]:
        """Begin the conversation about the clip anew; the frame that the page shows still holds."""
        anew = None
        if shown is not None:
            anew = replace(shown, session=self.answerer.session(shown.encoded))
        yield NOTHING_ASKED | {
            "shown": anew,
            "framed": in_frame(facts, None),
            "chips": suggested(anew),
            "saving": offered(anew, source.example if source else None),
        }


def _sentence(answer: Any) -> str:
    if answer.abstained or not answer.options or answer.kind == "talk":  # how sure it is, in words
        return answer.text
    return f"{answer.text}  ({100 * answer.confidence:.0f} % sure)"


def text_of(message: dict[str, Any]) -> str:
    """Return a message's words; the toolkit hands them back as a list of blocks."""
    content = message["content"]
    if isinstance(content, str):
        return unescape(content)
    return unescape(" ".join(block.get("text", "") for block in content if isinstance(block, dict)))


def _verdicts(answer: Any, details: dict[str, Any], opinions: dict[str, Any]) -> list[list[Any]]:
    """Return the motion that each method reads, all told from the answer's point of view."""
    probe, flow = opinions["probe"], opinions["optical_flow"]
    fitted = (flow["rotation_deg"], flow["slide_x_px"], flow["slide_y_px"], 0.0)
    turn, right, down, _ = answer.edit.matrix @ fitted + 0.0  # 0.0 has no sign of its own
    far = f"{turn:+.1f} degrees, {right:+.1f} px right, {down:+.1f} px down"
    sure = f"{100 * probe['probability']:.0f} % (not calibrated)"
    return [
        ["answer", details.get("direction") or "-", answer.text],
        ["linear probe", answer.edit.of_way(Motion(probe["motion"])).value, sure],
        ["optical flow", answer.edit.of_way(Motion(flow["motion"])).value, far],
    ]


def _band(answerer: Answerer, details: dict[str, Any]) -> str:
    """Return from where on an answer is told, and where this one stands."""
    from geotlm_lm import LEAST_SURE  # with the model's libraries

    threshold = answerer.bundle.calibration.contact_threshold
    share = details.get("evidence", {}).get("contact_share", 0.0)
    side = "withheld" if details.get("abstained") else "told"
    return (
        f"Contact share {share:.3f}; below {threshold:.3f} no direction is claimed, nor that "
        f"nothing touches a gel that has changed. What is less than {LEAST_SURE:.0%} sure is a "
        f"guess: this answer is **{side}**."
    )


def code_of(source: Source, questions: list[str], shown: LoadedClip) -> str:
    """Return the program that asks the questions of a conversation about its recording.

    The files of an upload are named as their owner knows them, several images by their folder.
    """
    name = Path(source.path).name if isinstance(source.path, str) else source.name
    path = name if source.example is None else f"app/examples/{name}"
    frame, usual = shown.session.frame, FrameSpec()
    stated = {field.name: getattr(frame, field.name) for field in fields(frame)}
    stated = {field: value for field, value in stated.items() if value != getattr(usual, field)}
    span = "" if source.span is None else f", span={source.span}"
    return "\n".join(
        [
            "from geotlm_lm import Answerer, FrameSpec, read_clip",
            "",
            "answerer = Answerer.load()",
            f"clip = read_clip({_arguments(path, topic=source.topic)})",
            f"frame = FrameSpec({_arguments(**stated)})",
            f"talk = answerer.session(answerer.encode(clip{span}), frame=frame)",
            f"for question in {questions!r}:",
            "    print(talk.ask(question).text)",
        ]
    )


def _arguments(*given: Any, **named: Any) -> str:
    named = {name: value for name, value in named.items() if value is not None}
    return ", ".join([*map(repr, given), *(f"{name}={value!r}" for name, value in named.items())])
