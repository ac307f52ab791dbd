"""Answer what was understood: decide each part, word it, and say how sure the whole is."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.deciding import (
    Decided,
    decided_parts,
    first_withheld,
    frame_after,
    guess_words,
    withheld_words,
)
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.evidence_of import evidence_of, recording_of, regions_of
from geotlm_lm.answering.measured_motion import MeasuredMotion
from geotlm_lm.answering.own_words import own_words
from geotlm_lm.answering.said import Said
from geotlm_lm.answering.understanding import Understood
from geotlm_lm.answering.withholding import LEAST_SURE
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import WAYS
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Measure, Recording
from geotlm_lm.query.decision import Decision, Evidence
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.forms import decided, in_form, told_in_form
from geotlm_lm.query.phrases import where_phrase
from geotlm_lm.query.replies import replies

_OF_FILE = ("setup", "recording", "help", "talk")
"""Asks that are answered without a look at any motion."""

SAME_RATE = 0.02
"""How far a stated frame rate may be from the frames' own to be the same, "30" for 29.97."""

_UNSURE = (*_OF_FILE, "unanswerable", "not-understood", "again")
"""Asks whose answers claim nothing of a motion."""


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
    return _told(bundle, understood, decided_parts(query, frame, clips), started, named)


def says(query: t.Query, frame: FrameSpec, *clips: Encoded) -> Said:
    """Return what is answered to a query.

    Args:
        query: What is asked.
        frame: What held before.
        *clips: One, or two that follow each other.
    """
    found = decided_parts(query, frame, clips)
    now = frame_after(query, frame, clips[-1].clip.frames.shape[2])
    recording = recording_of(found[0].clips[-1] if found else clips[-1]).at_rate(now.rate_hz)
    decisions = tuple(one.decision for one in found)
    return Said(in_form(decisions, query.form, recording), now, decisions)


def _told(
    bundle: Bundle,
    understood: Understood,
    told: tuple[Decided, ...],
    started: float,
    named: str | None,
) -> Answer:
    """Word the decisions on every part of a query."""
    found, encoded = [one.decision for one in told], told[0].clips[-1]
    first = found[0]
    evidence = evidence_of(encoded).at_rate(first.frame.rate_hz)
    sure = understood.probability * min(one.probability for one in found)
    withheld = first_withheld(bundle, told)
    is_silent = all(one.missing is not None or one.part.ask.kind in _UNSURE for one in found)
    kind = first.part.ask.kind
    is_guess = not is_silent and _is_guess(found)
    if withheld is not None:
        words = _Words(withheld_words(withheld, understood), "rule", named)
    else:
        words = _words(bundle, encoded, understood, found, evidence.recording, sure, named)
        if is_guess:
            guess = guess_words(words.text, understood, min(map(_motion_chance, found)))
            words = _Words(guess, "rule", words.named)
    is_abstained = withheld is not None or is_silent or is_guess
    plain = _plain(encoded, understood, first.frame, words.text, started)
    return replace(
        plain,
        kind=kind,
        notes=(*plain.notes, *_notes(found, evidence, recording_of(encoded))),
        abstained=is_abstained and kind not in _OF_FILE,
        confidence=sure if kind in _OF_FILE else 0.0 if is_abstained else sure,
        direction=None if is_abstained or kind in _NO_WAY else _direction(first),
        decided=None if is_abstained else decided(first, evidence.recording),
        options=_options(first, evidence),
        amount=_amount(first),
        motion=MeasuredMotion.of(encoded.belief, evidence.recording, first.frame),
        told_by=words.told_by,
        point_of_view=words.named,
    )


class _Words(NamedTuple):
    """A sentence, whose it is, and the point of view that was named last, in it or before."""

    text: str
    told_by: Literal["model", "rule"]
    named: str | None


def _words(
    bundle: Bundle,
    encoded: Encoded,
    understood: Understood,
    found: Sequence[Decision],
    recording: Recording,
    sure: float,
    named: str | None,
) -> _Words:
    """Return the language model's sentence where it has one and its point of view is not known."""
    form, where = understood.query.form, where_phrase(found[0])
    if len(found) == 1 and form == "sentence" and where != named:
        text = own_words(bundle, encoded, found[0])
        if text is not None:
            return _Words(text, "model", where if where in text else named)
    keys = understood.keys
    text, named = told_in_form(found, form, recording, sure=sure, keys=keys, named=named)
    return _Words(text, "rule", named)


def _is_guess(found: Sequence[Decision]) -> bool:
    """Tell whether what is told is more likely wrong than right; amounts have spans instead."""
    told = [one for one in found if one.part.ask.kind not in ("why", "how-sure", "alternatives")]
    return any(_motion_chance(one) < LEAST_SURE for one in told)


def _motion_chance(decision: Decision) -> float:
    """Return the probability of a decision but for how near its amounts are."""
    if decision.part.ask.kind != "amount" or decision.missing is not None:
        return decision.probability
    return min((one.chance for one in decision.movements), default=decision.probability)


def _notes(found: Sequence[Decision], evidence: Evidence, file: Recording) -> tuple[str, ...]:
    """Return what pixels are of, what a track found amiss, and which of two rates was used."""
    notes = () if evidence.track is None else evidence.track.notes
    amounts = [one for decision in found for one in decision.amounts]
    amounts += [one.amount for decision in found for one in decision.movements if one.amount]
    stated_hz, file_hz = found[0].frame.rate_hz, file.rate_hz
    is_timed = any("/" in one.unit for one in amounts) or any(one.times for one in found)
    is_other = stated_hz and file_hz and not math.isclose(stated_hz, file_hz, rel_tol=SAME_RATE)
    if is_timed and is_other:
        used_hz = evidence.recording.rate_hz
        is_stated = used_hz == stated_hz
        left = f"{file_hz:g} that the file tells" if is_stated else f"{stated_hz:g} that was stated"
        notes += (f"Told at {used_hz:g} frames per second, not at the {left}.",)
    if not any(one.unit.startswith("px") for one in amounts):
        return notes
    size = f"{evidence.recording.columns}x{evidence.recording.rows}"
    return (*notes, f"Pixels are those of the {size} frames; tell the mm per pixel to have mm.")


_NO_WAY = ("recording", "setup", "help", "talk", "place", "when", "how-long", "how-often")


def _direction(decision: Decision) -> Motion | None:
    if decision.still_axis is not None:
        return None
    return decision.movements[0].way if decision.movements else decision.rest


def _amount(decision: Decision) -> Measure | None:
    moves = () if decision.still_axis is not None else decision.movements
    amounts = decision.amounts or tuple(one.amount for one in moves[:1])
    return amounts[0] if amounts else None


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
    belief = evidence.belief.seen(decision.edit)
    found = {way.value: belief.ways[way] for ways in WAYS.values() for way in ways}
    touching = max(belief.contact, *(belief.moves(one) for one in WAYS))
    still = touching
    for component in WAYS:
        still *= max(1 - belief.moves(component) / max(touching, 1e-9), 0.0)
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
        notes=(*encoded.clip.notes, *understood.notes),
        query=understood.line,
        understood=understood.probability,
        resumed=understood.query,
    )
