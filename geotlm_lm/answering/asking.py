"""Answer what was understood: decide each part, word it, and say how sure the whole is."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from geotlm_lm.answering.answer import Answer, Comparison
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.evidence_of import evidence_of, recording_of, regions_of
from geotlm_lm.answering.measured_motion import MeasuredMotion
from geotlm_lm.answering.own_words import own_words
from geotlm_lm.answering.understanding import Understood
from geotlm_lm.answering.withholding import LEAST_SURE, tentative, why_withheld
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, reverse
from geotlm_lm.core.twist import WAYS
from geotlm_lm.query import types as t
from geotlm_lm.query.decision import Decision, Evidence
from geotlm_lm.query.execute import execute
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.forms import decided, in_form
from geotlm_lm.query.phrases import last_named, naming_once
from geotlm_lm.query.replies import replies

_OF_FILE = ("setup", "recording", "help", "talk")
"""Asks that are answered without a look at any motion."""

_UNSURE = (*_OF_FILE, "unanswerable", "not-understood", "again")
"""Asks whose answers claim nothing of a motion."""


def of_two(query: t.Query) -> bool:
    """Tell whether a query asks about two clips."""
    return any(map(_is_of_two, query.parts))


def _is_of_two(part: t.Part) -> bool:
    return part.ask.kind in ("compare", "which-clip") or part.subject.clip in t.OF_SEVERAL


def frame_after(query: t.Query, frame: FrameSpec, columns: int) -> FrameSpec:
    """Return the frame in which the facts that were stated hold; the one before if they cannot."""
    try:
        return with_facts(frame, query.facts, columns)
    except UsageError:  # no camera has such pixels: `_decided` says so
        return frame


def answer(
    bundle: Bundle,
    encoded: Encoded,
    understood: Understood,
    frame: FrameSpec,
    other: Encoded | None = None,
    named: str | None = None,
) -> Answer:
    """Answer a question about a clip.

    Args:
        bundle: The model.
        encoded: The clip.
        understood: What is asked.
        frame: What held before.
        other: The clip before it, for parts that ask of that one.
        named: The point of view that was named last, in words.
    """
    started = time.perf_counter()
    query = understood.query
    if understood.ask_back is not None:
        now = frame_after(query, frame, encoded.clip.frames.shape[2])
        return _plain(encoded, understood, now, understood.ask_back, started)
    if not query.parts:
        return _noted(encoded, understood, frame, started)
    clips = (encoded,) if other is None else (other, encoded)
    return _told(bundle, understood, _decided(query, frame, clips, named), started)


def says(query: t.Query, frame: FrameSpec, *clips: Encoded) -> tuple[str, FrameSpec]:
    """Return what is answered to a query in plain words, and the frame that holds from then on.

    Args:
        query: What is asked.
        frame: What held before.
        *clips: One, or two that follow each other.
    """
    found = _decided(query, frame, clips)
    now = frame_after(query, frame, clips[-1].clip.frames.shape[2])
    recording = recording_of(found[0].clips[-1] if found else clips[-1]).at_rate(now.rate_hz)
    return in_form([one.decision for one in found], query.form, recording), now


@dataclass(frozen=True)
class _Decided:
    """What one part is answered by, and the clips that it is about."""

    decision: Decision
    clips: tuple[Encoded, ...]

    def withheld(self, bundle: Bundle) -> str | None:
        """Return what is said in place of it; None where it is told."""
        each = self.decision.each if len(self.clips) == 2 else (self.decision,)
        reasons = (
            why_withheld(bundle, clip, one) for clip, one in zip(self.clips, each, strict=False)
        )
        return next((one for one in reasons if one is not None), None)


def _decided(
    query: t.Query, frame: FrameSpec, clips: tuple[Encoded, ...], named: str | None = None
) -> tuple[_Decided, ...]:
    decisions, told_of = [], []
    for part in query.parts:
        about = clips
        if not _is_of_two(part):
            is_first = part.subject.clip in ("first", "previous")
            about = clips[:1] if is_first else clips[-1:]
            part = replace(part, subject=replace(part.subject, clip=None))
        alone = replace(query, parts=(part,))
        decisions += execute(alone, evidence_of(*about), frame)
        told_of.append(about)
    return tuple(map(_Decided, naming_once(decisions, named), told_of))


def compare(
    bundle: Bundle,
    clips: tuple[Encoded, Encoded],
    understood: Understood,
    frame: FrameSpec,
) -> Comparison:
    """Answer a question about two clips."""
    first, second = clips
    now = frame_after(understood.query, frame, first.clip.frames.shape[2])
    open_ = Understood(t.Query((t.Part(t.Ask("way")),)), "way", 1.0)
    each = [answer(bundle, one, open_, now) for one in clips]
    query = understood.query
    if understood.ask_back is not None or not query.parts:
        text, sure, word = answer(bundle, second, understood, frame).text, 0.0, None
    else:
        text, sure, word = _compared(bundle, understood, _decided(query, frame, clips))
    relation = _relation(each)
    kind = query.parts[0].ask.kind if query.parts else "fact"
    if kind == "compare" and word is None and sure > 0:
        word = relation
    return Comparison(text, relation, sure, sure == 0.0, *each, word, kind, now, query)


def _compared(
    bundle: Bundle, understood: Understood, found: tuple[_Decided, ...]
) -> tuple[str, float, str | None]:
    """Return the words of a comparison, how sure they are, and the deciding one."""
    form, decisions = understood.query.form, [one.decision for one in found]
    recording = recording_of(found[0].clips[0]).at_rate(decisions[0].frame.rate_hz)
    withheld = next((why for one in found if (why := one.withheld(bundle)) is not None), None)
    if withheld is not None:
        return _withheld(withheld, understood), 0.0, None
    sure = understood.probability * min(one.probability for one in decisions)
    text = in_form(decisions, form, recording, sure=sure, keys=understood.keys)
    if any(one.missing is not None for one in decisions):
        return text, 0.0, None
    if sure < LEAST_SURE:
        return _guess(text, understood, sure), 0.0, None
    return text, sure, decided(decisions[0], recording)


def _withheld(why: str, understood: Understood) -> str:
    if understood.keys:
        return json.dumps(dict.fromkeys(understood.keys))
    is_json = understood.query.form == "json"
    return json.dumps({"missing": why, "probability": 0.0}) if is_json else why


def _guess(text: str, understood: Understood, sure: float) -> str:
    """Return words as a guess; JSON holds its own probability, or no values under given keys."""
    if understood.keys:
        return json.dumps(dict.fromkeys(understood.keys))
    return text if understood.query.form == "json" else tentative(text, sure)


def _relation(each: Sequence[Answer]) -> str:
    one, other = (answer.direction for answer in each)
    if None in (one, other):
        return "unknown"
    if one == other:
        return "same"
    return "opposite" if one in DIRECTED and other == reverse(one) else "different"


def _told(
    bundle: Bundle, understood: Understood, told: tuple[_Decided, ...], started: float
) -> Answer:
    """Word the decisions on every part of a query."""
    query, found, encoded = understood.query, [one.decision for one in told], told[0].clips[-1]
    first = found[0]
    evidence = evidence_of(encoded).at_rate(first.frame.rate_hz)
    sure = understood.probability * min(one.probability for one in found)
    withheld = next((why for one in told if (why := one.withheld(bundle)) is not None), None)
    told_by, text = "rule", None
    is_plain = query.form == "sentence" and not first.is_frame_known
    if len(found) == 1 and is_plain and withheld is None:
        text = own_words(bundle, encoded, first)
        told_by = "rule" if text is None else "model"
    if text is None:
        keys = understood.keys
        text = in_form(found, query.form, evidence.recording, sure=sure, keys=keys)
    is_silent = all(one.missing is not None or one.part.ask.kind in _UNSURE for one in found)
    kind = first.part.ask.kind
    is_guess = not is_silent and _is_guess(found)
    if withheld is not None:
        text, told_by = _withheld(withheld, understood), "rule"
    elif is_guess:
        text, told_by = _guess(text, understood, min(map(_motion_chance, found))), "rule"
    is_abstained = withheld is not None or is_silent or is_guess
    plain = _plain(encoded, understood, first.frame, text, started)
    moves = first.movements
    return replace(
        plain,
        kind=kind,
        notes=(*plain.notes, *_notes(found, evidence)),
        abstained=is_abstained and kind not in _OF_FILE,
        confidence=sure if kind in _OF_FILE else 0.0 if is_abstained else sure,
        direction=None if is_abstained or kind in _NO_WAY else _direction(first),
        decided=None if is_abstained else decided(first, evidence.recording),
        options=_options(first, evidence),
        amount=first.amounts[0] if first.amounts else moves[0].amount if moves else None,
        motion=MeasuredMotion.of(encoded.belief, evidence.recording, first.frame),
        told_by=told_by,
        point_of_view=None if withheld is not None else last_named(found),
    )


def _is_guess(found: Sequence[Decision]) -> bool:
    """Tell whether what is told is more likely wrong than right; amounts have spans instead."""
    told = [one for one in found if one.part.ask.kind not in ("why", "how-sure", "alternatives")]
    return any(_motion_chance(one) < LEAST_SURE for one in told)


def _motion_chance(decision: Decision) -> float:
    """Return the probability of a decision but for how near its amounts are."""
    if decision.part.ask.kind != "amount" or decision.missing is not None:
        return decision.probability
    return min((one.chance for one in decision.movements), default=decision.probability)


def _notes(found: Sequence[Decision], evidence: Evidence) -> tuple[str, ...]:
    """Return what pixels are of, where amounts are told in them, and what a track found amiss."""
    notes = () if evidence.track is None else evidence.track.notes
    amounts = [one for decision in found for one in decision.amounts]
    amounts += [one.amount for decision in found for one in decision.movements if one.amount]
    if not any(one.unit.startswith("px") for one in amounts):
        return notes
    size = f"{evidence.recording.columns}x{evidence.recording.rows}"
    return (*notes, f"Pixels are those of the {size} frames; tell the mm per pixel to have mm.")


_NO_WAY = ("recording", "setup", "help", "talk", "place", "when", "how-long", "how-often")


def _direction(decision: Decision) -> Motion | None:
    return decision.movements[0].way if decision.movements else decision.rest


def _options(decision: Decision, evidence: Evidence) -> dict[str, float]:
    """Return the probability of each answer that was possible, by its deciding word."""
    ask = decision.part.ask
    if decision.verdict is not None:
        share = decision.probability
        return (
            {"yes": share, "no": 1 - share} if decision.verdict else {"yes": 1 - share, "no": share}
        )
    if ask.kind == "choice" and decision.chances:
        return {
            decided(replace(decision, options=(at,)), evidence.recording): chance
            for at, chance in enumerate(decision.chances)
        }
    if ask.kind not in ("way", "kind", "amount", "how-sure", "alternatives"):
        return {}
    belief = decision.edit.of_belief(evidence.belief)
    found = {way.value: belief.ways[way] for ways in WAYS.values() for way in ways}
    touching = max(belief.contact, *(belief.counts(one) for one in WAYS))
    still = touching
    for component in WAYS:
        still *= max(1 - belief.counts(component) / max(touching, 1e-9), 0.0)
    return found | {"still": still, "none": 1 - touching}


def _noted(encoded: Encoded, understood: Understood, before: FrameSpec, started: float) -> Answer:
    try:
        now = with_facts(before, understood.query.facts, encoded.clip.frames.shape[2])
    except UsageError:  # no camera has such pixels
        return _plain(encoded, understood, before, replies()["missing"]["pixel"], started)
    told = _plain(encoded, understood, now, f"Noted: {now.summary()}.", started)
    return replace(told, abstained=False, confidence=understood.probability)


def _plain(
    encoded: Encoded, understood: Understood, frame: FrameSpec, text: str, started: float
) -> Answer:
    """Return an answer that claims nothing."""
    told = 1e3 * (time.perf_counter() - started)
    timing = encoded.timing_ms | {"read": understood.milliseconds, "answer": told}
    timing["total"] = sum(timing.values())
    return Answer(
        text=text,
        direction=None,
        confidence=0.0,
        abstained=True,
        frame=frame,
        options={},
        evidence=regions_of(encoded),
        timing_ms=timing,
        kind="fact",
        frames_used=encoded.clip.frame_numbers,
        notes=encoded.clip.notes,
        query=understood.line,
        understood=understood.probability,
        resumed=understood.query,
    )
