"""From a question to its answer: understand, evaluate, tell.

A question is read into programs, each evaluated exactly on what is believed of the recording. The
likeliest reading is answered, where likelier than all others or where likely ones come to the same;
it is asked back only between close readings that come to different values.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from geotlm_lm.answering.answer import Answer, Comparison, MeasuredMotion
from geotlm_lm.answering.encoded import Encoded, regions_of
from geotlm_lm.answering.reasons import contact_steps
from geotlm_lm.answering.understanding import (
    LEAST_SURE,
    Asked,
    Understood,
    is_guess,
    looked_at,
)
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.twist import WAYS
from geotlm_lm.query.evaluate import Evidence, with_facts
from geotlm_lm.query.phrases import facts_phrase, is_talk, label_of, replies, restated
from geotlm_lm.query.program import BARE, TEMPLATES, Program, head_of, of, type_of
from geotlm_lm.query.telling import Teller, Wording
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Measure,
    Moved,
    Record,
    Recording,
    Remark,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.query.written import decided, guessed, worded

PLAIN = 0.5
"""Probability of a reading below which an answer says how the question was taken."""

SAME_RATE = 0.02
"""How far a stated frame rate may be from the frames' own to be the same, "30" for 29.97."""

PIXELS_NOTE = "Pixels are those of the"
"""Begins the note on a unit, the only one about nothing that was guessed."""

SILENT = ("cannot", "not-understood", "talk", "help")
"""Remarks that tell nothing of a recording."""


def answer(asked: Asked, understood: Understood) -> Answer:
    """Answer what was understood."""
    started = time.perf_counter()
    program = understood.program
    frame = asked.frame_after(program)
    plain = _plain(asked, understood, frame)
    if understood.ask_back is not None:
        result = replace(plain, text=understood.ask_back)
    elif not program.answers:
        result = _noted(asked, understood, plain)
    else:
        result = _told(asked, understood, plain)
    timing = plain.timing_ms | {"answer": 1e3 * (time.perf_counter() - started)}
    return replace(result, timing_ms=timing | {"total": sum(timing.values())})


@dataclass(frozen=True)
class Worded:
    """What everything that is asked comes to, in words.

    Args:
        values: Each with what withholds it.
        wording: Of all of them.
        teller: Of the recording, in the frame in which what was stated holds.
        sure: That all of it but guesses is right, the reading included.
        guesses: Which of the values are more likely wrong than right.
    """

    values: tuple[Value, ...]
    wording: Wording
    teller: Teller
    sure: float
    guesses: tuple[bool, ...]


def worded_values(asked: Asked, program: Program, probability: float = 1.0) -> Worded:
    """Word what everything that a program asks comes to.

    Args:
        asked: About what.
        program: With its numbers and words, asking something.
        probability: That the program is what was meant.
    """
    values, frame = asked.values(program), asked.frame_after(program)
    recording = asked.evidence[-1].recording
    recording = recording.at_rate(frame.rate_hz, overrides=len(asked.clips) == 1)
    teller = Teller(recording, frame, asked.named)
    shown = values
    if program.form in (*TEMPLATES, *BARE):  # what a program reads holds no guess
        shown = tuple(_without_guesses(each, probability) for each in values)
    values = shown if program.form in TEMPLATES else values
    # A sentence tells how it was taken where its reading is doubtful.
    is_named = program.form == "sentence" and probability < PLAIN
    reading = 1.0 if is_named else probability
    guesses = tuple(is_guess(each, reading) for each in values)
    # Where all are guesses the whole answer says so, once.
    marked = (False,) * len(values) if all(guesses) else guesses
    certain = [each for each, is_marked in zip(values, marked, strict=True) if not is_marked]
    sure = probability * min(each.probability for each in certain)
    chances = [_chance(each, probability) if is_marked else None
               for each, is_marked in zip(values, marked, strict=True)]  # fmt: skip
    chances = () if program.form in BARE else chances
    wording = worded(shown, program.form, teller, sure, chances)
    return Worded(values, wording, teller, sure, guesses)


def _chance(value: Value, understood: float) -> float:
    """Return how probable a guess is, its reading included where that alone makes it one."""
    chance = value.probability
    return chance if chance < LEAST_SURE else understood * chance


def _told(asked: Asked, understood: Understood, plain: Answer) -> Answer:
    """Word what everything that is asked comes to, and tell how sure and of what it is."""
    program, evidence = understood.program, asked.evidence[-1]
    words = worded_values(asked, program, understood.probability)
    values, teller, sure, text = words.values, words.teller, words.sure, words.wording.text
    is_own = partial(asked.says, understood.question, understood.written, text)
    is_talk = all(isinstance(each, Remark) for each in values)
    if head_of(program.answers[0]).word in ("why", "why-of"):
        text = " ".join(
            [*contact_steps(plain.evidence), f"Therefore: {text[:1].lower()}{text[1:]}"]
        )
    text = _framed(text, understood, words)
    first = values[0]
    # Below one half, the reading included, nothing is decided, though it is told. What is asked
    # besides the first withholds nothing of it.
    is_abstained = words.guesses[0] or sure < LEAST_SURE or not first.is_known
    is_abstained |= any(getattr(each, "kind", "") in SILENT for each in values)
    encoded = looked_at(first, asked.clips)[-1]
    withheld = _withheld(asked, understood)
    return replace(
        plain,
        text=text,
        is_own=is_own,
        kind=type_of(program.answers[0]),
        notes=(*plain.notes, *withheld, *_notes(values, teller.recording, evidence)),
        withheld=withheld,
        abstained=is_abstained,
        confidence=0.0 if is_abstained else sure,
        direction=None if is_abstained or is_talk else _direction(first),
        decided=None if is_abstained else decided(first, teller),
        options=_options(first, encoded),
        amount=_amount(first),
        motion=MeasuredMotion.of(encoded.belief.seen(first.edit), teller.recording, plain.frame),
        point_of_view=words.wording.named,
        values=values,
    )


def _framed(text: str, understood: Understood, words: Worded) -> str:
    """Return an answer with how its question was taken, and as a guess where it is one.

    What a program reads stays as it is.
    """
    if understood.program.form in (*TEMPLATES, *BARE):
        return text
    noted = f"Noted: {facts_phrase(understood.program.facts)}. " * understood.is_resumed
    if all(words.guesses):
        text = guessed(text, min(_chance(each, understood.probability) for each in words.values))
    program = understood.program
    if understood.probability < PLAIN and program.form == "sentence" and not is_talk(program):
        return f"{noted}Taken as: {restated(program)}. {text}"
    return f"{noted}{text}"


def _without_guesses(value: Value, understood: float) -> Value:
    """Return a value with nothing in the place of what is more likely wrong than right."""
    if isinstance(value, Record):
        fields = tuple((key, _without_guesses(each, understood)) for key, each in value.fields)
        events = value.shown if understood >= LEAST_SURE else ()
        return replace(value, fields=fields, shown=events)
    is_unsure = value.is_known and (understood < LEAST_SURE or is_guess(value, understood))
    return Unknown(of=value.of, reason="unsure", edit=value.edit) if is_unsure else value


def _withheld(asked: Asked, understood: Understood) -> tuple[str, ...]:
    """Return the sentence with the reason of what a form that programs read leaves out."""
    chance, program = understood.probability, replace(understood.program, form="sentence")
    values = (_without_guesses(each, chance) for each in asked.values(understood.program))
    if understood.program.form not in (*TEMPLATES, *BARE) or all(map(_is_whole, values)):
        return ()
    words = worded_values(asked, program, chance)
    return (_framed(words.wording.text, replace(understood, program=program), words),)


def _is_whole(value: Value) -> bool:
    if isinstance(value, Record):
        return all(_is_whole(each) for _, each in value.fields)
    return value.is_known


def _noted(asked: Asked, understood: Understood, plain: Answer) -> Answer:
    """Answer what only states facts."""
    facts = understood.program.facts
    try:
        with_facts(asked.frame, facts, asked.clips[-1].clip.frames.shape[2])
    except UsageError:
        return replace(plain, text=replies()["missing"]["pixel"])
    text = f"Noted: {facts_phrase(facts)}."
    return replace(plain, text=text, abstained=False, confidence=understood.probability)


def _direction(value: Value) -> Motion | None:
    moved = value.moved
    if moved is None or moved.still_axis is not None:
        return None
    return moved.movements[0].way if moved.movements else moved.rest


def _amount(value: Value) -> Measure | None:
    if isinstance(value, Amount):
        return value.amount
    moved = value if isinstance(value, Moved) else None
    return moved.movements[0].amount if moved is not None and moved.movements else None


def _options(value: Value, encoded: Encoded) -> dict[str, float]:
    """Return the probability of each answer that was possible, by its deciding word."""
    if isinstance(value, Truth):
        return {"yes": value.chance, "no": 1 - value.chance}
    if isinstance(value, Choice) and head_of(value.of).word in ("choose", "choose-not"):
        cases = head_of(value.of).arguments[0]
        return {label_of(case): chance for case, chance in zip(cases, value.chances, strict=True)}
    if not isinstance(value, Moved):
        return {}
    belief = encoded.belief.seen(value.edit)
    chances = {way.value: belief.ways[way] for ways in WAYS.values() for way in ways}
    touching = max(belief.contact, *(belief.moves(part) for part in WAYS))
    still = touching
    for part in WAYS:
        still *= max(1 - belief.moves(part) / max(touching, 1e-9), 0.0)
    return chances | {"still": still, "none": 1 - touching}


def _measures(value: Value) -> list[Measure]:
    if isinstance(value, Record):
        return [each for _, field in value.fields for each in _measures(field)]
    compared = (value,) if isinstance(value, Amount) else getattr(value, "amounts", ())
    measures = [each.amount for each in compared]
    moves = () if value.moved is None else value.moved.movements
    return measures + [move.amount for move in moves if move.amount]


def _notes(values: Sequence[Value], recording: Recording, evidence: Evidence) -> tuple[str, ...]:
    """Return what pixels are of, what a track found amiss, and which of two rates was used."""
    track = evidence.worlds.track
    notes = () if track is None else track.notes
    measures = [each for value in values for each in _measures(value)]
    used, own = recording.rate_hz, evidence.recording.rate_hz
    is_timed = any("/" in each.unit or each.unit in ("s", "ms", "min") for each in measures)
    if is_timed and used and own and abs(used - own) > SAME_RATE * own:
        notes += (f"Told at {used:g} frames per second, not at the {own:g} that the file tells.",)
    if not any(each.unit.startswith("px") for each in measures):
        return notes
    size = f"{recording.columns}x{recording.rows}"
    return (*notes, f"{PIXELS_NOTE} {size} frames; tell the mm per pixel to have mm.")


def _plain(asked: Asked, understood: Understood, frame: FrameSpec) -> Answer:
    """Return an answer that claims nothing."""
    encoded = asked.clips[-1]
    return Answer(
        text="",
        direction=None,
        confidence=0.0,
        abstained=True,
        frame=frame,
        options={},
        evidence=regions_of(encoded),
        timing_ms=encoded.timing_ms | {"read": understood.milliseconds},
        kind="fact",
        frames_used=encoded.clip.frame_numbers,
        notes=(*encoded.clip.notes, *understood.notes),
        query=understood.line,
        understood=understood.probability,
        resumed=understood.program,
        point_of_view=asked.named,
        question=understood.question,
        written=understood.written,
    )


def compared(asked: Asked, understood: Understood) -> Comparison:
    """Answer what is asked of two clips together."""
    result = answer(asked, understood)
    frame, open_ = result.frame, Understood(Program((of("way", "all"),)), 1.0)
    each = [answer(replace(asked, clips=(clip,), frame=frame), open_) for clip in asked.clips]
    return Comparison(
        text=result.text,
        relation=_relation(*(reply.direction for reply in each)),
        confidence=result.confidence,
        abstained=result.abstained,
        first=each[0],
        second=each[1],
        decided=result.decided,
        kind=result.kind,
        frame=frame,
        resumed=result.resumed,
    )


def _relation(first: Motion | None, second: Motion | None) -> str:
    if first is None or second is None:
        return "unknown"
    if first == second:
        return "same"
    return "opposite" if first in DIRECTED and second == opposite(first) else "different"
