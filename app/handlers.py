"""What the page's buttons do, as plain functions; knows nothing of the page's toolkit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from geotlm_lm import (
    FrameSpec,
    GeoTLMError,
    Motion,
)

from .clip_loading import LoadedClip

if TYPE_CHECKING:
    from geotlm_lm import Answerer

DIRECTION_QUESTION = "Which way is it moving?"
AMOUNT_QUESTION = "How far did it go?"
"""Asked of what was just simulated."""

COMPARISON_QUESTION = "Do they go the same way?"


@dataclass(frozen=True)
class Reply:
    """One answer in the parts the page shows; `motion` is what it says in the camera image."""

    sentence: str
    motion: Motion | None
    probabilities: dict[str, float]
    details: dict[str, Any]
    notes: str
    band: str
    regions: list[list[Any]]
    verdicts: list[list[Any]]
    timing: str


def ask(
    answerer: Answerer, shown: LoadedClip | None, question: str, frame: FrameSpec | None = None
) -> Reply:
    """Answer `question` about the clip that is shown, by itself.

    Args:
        answerer: The model.
        shown: The clip.
        question: In plain English.
        frame: In which directions are told; None for the camera's.

    Raises:
        GeoTLMError: If there is no clip or no question, in one sentence.
    """
    shown = _open(shown)
    answer = answerer.ask(shown.encoded, question, frame=frame or FrameSpec())
    return _reply(answerer, shown, answer)


def converse(
    answerer: Answerer, shown: LoadedClip | None, question: str, facts: Mapping[str, Any]
) -> Iterator[str | Reply]:
    """Answer the next question of the conversation about the clip that is shown.

    Yields:
        The answer's words one by one, and last the reply.

    Args:
        answerer: The model.
        shown: The clip.
        question: What is asked, or a fact about the recording.
        facts: Fields of the `FrameSpec` that hold from now on.

    Raises:
        GeoTLMError: If there is no clip or no question, in one sentence.
    """
    shown = _open(shown)
    shown.session.frame = replace(shown.session.frame, **facts)
    for told in shown.session.stream(question):
        yield told if isinstance(told, str) else _reply(answerer, shown, told)


def _open(shown: LoadedClip | None) -> LoadedClip:
    if shown is None:
        raise GeoTLMError("No recording is open; upload a clip first.")
    return shown


def _reply(answerer: Answerer, shown: LoadedClip, answer: Any) -> Reply:
    says_how_sure = answer.kind == "how-sure"  # in its own words
    is_sure_of_something = not answer.abstained and answer.options and not says_how_sure
    told = f"  ({100 * answer.confidence:.0f} % sure)" if is_sure_of_something else ""
    details = answer.to_dict()
    timing = details.get("timing_ms", {}) | shown.opinions["timing_ms"]
    return Reply(
        sentence=answer.text + told,
        motion=answer.in_the_image,
        probabilities=dict(answer.options),
        details=details | {"second_opinions": shown.opinions},
        notes=_notes(answer, shown),
        band=_band(answerer, details),
        regions=region_rows(details.get("evidence", {})),
        verdicts=_verdicts(answer, shown.opinions),
        timing=" · ".join(f"{name} {value:.1f} ms" for name, value in timing.items()),
    )


def _notes(answer: Any, shown: LoadedClip) -> str:
    """Return what is to be known of the answer: neither of the clip, nor said in it already."""
    return "\n".join(f"- {note}" for note in answer.notes if note not in shown.encoded.clip.notes)


def compare(
    answerer: Answerer,
    first: LoadedClip | None,
    second: LoadedClip | None,
    question: str = COMPARISON_QUESTION,
    frame: FrameSpec | None = None,
) -> dict[str, Any]:
    """Answer a question about two clips, and which way each goes.

    Args:
        answerer: The model.
        first: A clip.
        second: Another.
        question: In plain English.
        frame: In which directions are told; None for the camera's.

    Returns:
        Both answers under "first" and "second", "relation", and "text", the sentence.

    Raises:
        GeoTLMError: If a clip is missing.
    """
    if first is None or second is None:
        raise GeoTLMError("A comparison needs two recordings; upload both.")
    framed = {} if frame is None else {"frame": frame}
    return answerer.compare(first.encoded, second.encoded, question, **framed).to_dict()


def direction_in_frame(frame: FrameSpec, direction: Any) -> str:
    """Return the last direction as another frame of reference names it.

    Args:
        frame: The frame the reader wants.
        direction: The motion in the camera image; None when none was told.
    """
    if direction is None:
        return f"Frame: {frame.sentence()}."
    return f"In this frame ({frame.sentence()}) that is **{frame.edit.of_way(direction).value}**."


def region_rows(evidence: dict[str, Any]) -> list[list[Any]]:
    """Return name, shear change (x right, y down) and contact mass of each region."""
    return [
        [
            name.replace("_", " "),
            values["shear_change_x"],
            values["shear_change_y"],
            values["contact_mass"],
        ]
        for name, values in evidence.get("regions", {}).items()
    ]


def _verdicts(answer: Any, opinions: dict[str, Any]) -> list[list[Any]]:
    """Return the motion that each method reads, all told from the answer's point of view."""
    probe, flow = opinions["probe"], opinions["optical_flow"]
    said = answer.to_dict().get("direction") or "-"
    sure = f"{100 * probe['probability']:.0f} % (not calibrated)"
    return [
        ["language model", said, answer.text],
        ["linear probe", answer.edit.of_way(Motion(probe["motion"])).value, sure],
        ["optical flow", answer.edit.of_way(Motion(flow["motion"])).value, _moved(flow, answer)],
    ]


def _moved(flow: dict[str, Any], answer: Any) -> str:
    """Return how far it went, from an answer's point of view; 0.0 has no sign of its own."""
    fitted = (flow["rotation_deg"], flow["slide_x_px"], flow["slide_y_px"], 0.0)
    turn, right, down, _ = answer.edit.matrix @ fitted + 0.0
    return f"{turn:+.1f} degrees, {right:+.1f} px right, {down:+.1f} px down"


def _band(answerer: Answerer, details: dict[str, Any]) -> str:
    """Return from where on an answer is told, and where this one stands."""
    from geotlm_lm import LEAST_SURE

    threshold = answerer.bundle.calibration.contact_threshold
    share = details.get("evidence", {}).get("contact_share", 0.0)
    side = "withheld" if details.get("abstained") else "told"
    return (
        f"Contact share {share:.3f}; below {threshold:.3f} no direction is claimed, and no motion, "
        f"verdict or choice that is less than {LEAST_SURE:.0%} sure, nor that nothing touches a "
        f"gel that has changed: this answer is **{side}**."
    )
