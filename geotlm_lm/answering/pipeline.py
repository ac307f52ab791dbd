"""From a question to its answer: understand, evaluate, tell.

A question is read into programs, each evaluated exactly on what is believed of the recording. The
likeliest reading is answered, where likelier than all others or where likely ones come to the same;
it is asked back only between close readings that come to different values.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

from geotlm_lm.answering.answer import Answer, Comparison
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.evidence_of import evidence_of, regions_of
from geotlm_lm.answering.measured_motion import MeasuredMotion
from geotlm_lm.answering.withholding import LEAST_SURE, is_guess, looked_at, told_or_not
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.twist import WAYS
from geotlm_lm.query.amounts import Measure, Recording
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import Evidence
from geotlm_lm.query.facts import FACTS, Fact, with_facts
from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.lines import write
from geotlm_lm.query.phrases import label_of
from geotlm_lm.query.program import LEANING, TWO_CLIPS, Program, head_of, is_void, of, type_of
from geotlm_lm.query.reader import Reader, Reading
from geotlm_lm.query.replies import replies
from geotlm_lm.query.restated import facts_phrase, is_plain, restated
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import Amount, Choice, Moved, Record, Remark, Truth, Unknown, Value
from geotlm_lm.query.written import decided, worded

UNDERSTOOD = 0.5
"""Probability of a reading from which on it is likelier than all others together."""

PLAIN = 0.5
"""Probability of a reading below which an answer says how the question was taken."""

UNLIKELY = 0.3
"""Probability below which the likeliest reading is asked back about whatever others there are: of
48 such questions of `tune` it was right in 8, of 97 read with 0.3 to 0.5 in 42."""

CLOSE = 0.8
"""Share of the likeliest reading's probability from which on another one is asked back about."""

OF_TWO = frozenset({*TWO_CLIPS, "of-first", "of-second", "of-previous"})
OF_BEFORE = frozenset({*LEANING, "again", "plain"})
"""Words of programs that are out of place where one recording is open, or nothing was asked."""

MOST_OFFERED = 30
"""Words of what was understood beyond which nobody would read it: what is asked back is short."""

UNDERSTOOD_FACTS = 0.7
"""Probability below which facts that would turn an answer are asked back about: they hold until
they are taken back."""

SAME_RATE = 0.02
"""How far a stated frame rate may be from the frames' own to be the same, "30" for 29.97."""

SILENT = ("cannot", "not-understood", "talk", "help")
"""Remarks that tell nothing of a recording."""

TEMPLATES = ("json", "csv", "pairs", "yaml", "tuple", "brackets")
"""Forms that programs read."""


# Understand


@dataclass(frozen=True)
class Understood:
    """What a question was taken to ask.

    Args:
        program: With its numbers and words, and what it leans on spelled out.
        probability: That this is what was meant.
        ask_back: What is asked where two readings are close, or a fact was not understood.
        notes: Which facts were not understood and change nothing.
        milliseconds: That reading took.
    """

    program: Program
    probability: float
    ask_back: str | None = None
    notes: tuple[str, ...] = ()
    milliseconds: float = 0.0

    @property
    def line(self) -> str:
        """The program in its words."""
        return write(self.program)


def understand(
    reader: Reader,
    question: str,
    before: Program | None = None,
    asked: Asked | None = None,
) -> Understood:
    """Read a question.

    Args:
        reader: The model that reads.
        question: As it was typed.
        before: What was asked last, if anything was.
        asked: About what: readings are compared by what they come to; None where the program
            itself is wanted.

    Raises:
        UsageError: If the question is empty or too long.
    """
    started = time.perf_counter()
    unlikely: frozenset[str] = frozenset()
    if asked is not None and len(asked.clips) < 2:
        unlikely |= OF_TWO
    if asked is not None and (before is None or not before.answers):
        unlikely |= OF_BEFORE
    readings = reader.readings(question, unlikely=unlikely)
    understood = _chosen(reader, readings, before or Program(), asked)
    return replace(understood, milliseconds=1e3 * (time.perf_counter() - started))


def _chosen(
    reader: Reader, readings: Sequence[Reading], before: Program, asked: Asked | None
) -> Understood:
    """Return the likeliest reading, those that come to the same values counted together."""
    readings = [each for each in readings if not is_void(each.program)] or readings
    programs = [_once(resumed(each.program, before)) for each in readings]
    groups: list[list[int]] = []
    for place, program in enumerate(programs):
        for group in groups:
            if _agree(programs[group[0]], program, asked):
                group.append(place)
                break
        else:
            groups.append([place])
    chances = [sum(readings[place].chance for place in group) for group in groups]
    best = max(range(len(groups)), key=chances.__getitem__)
    program = programs[groups[best][0]]
    understood = Understood(program, reader.calibrated(chances[best]))
    others = sorted(set(range(len(groups))) - {best}, key=lambda place: -chances[place])
    rival = programs[groups[others[0]][0]] if others else None
    is_close = bool(others) and chances[others[0]] >= CLOSE * chances[best]
    unclear = [fact.value for fact in program.facts if fact.name == "unclear"]
    if unclear and _matters(unclear, program, asked):
        return replace(understood, ask_back=replies()["unclear"][unclear[0]])
    if unclear:
        notes = tuple(replies()["unclear_same"][each] for each in unclear)
        understood = replace(understood, notes=notes)
    # What is told of no motion turns no robot the wrong way.
    is_unsure = understood.probability < (UNDERSTOOD if is_close else UNLIKELY)
    is_doubtful = is_unsure and not is_plain(program)
    if program.facts and understood.probability < UNDERSTOOD_FACTS:
        is_doubtful = is_doubtful or _turns(program, rival)
    rival = rival if is_close or program.facts else None
    return replace(understood, ask_back=_asked_back(program, rival)) if is_doubtful else understood


def _once(program: Program) -> Program:
    """Return a program that asks nothing twice."""
    return replace(program, answers=tuple(dict.fromkeys(program.answers)))


def _turns(program: Program, rival: Program | None) -> bool:
    """Tell whether facts that may not have been stated would hold from now on."""
    return rival is None or set(rival.facts) != set(program.facts)


def _agree(one: Program, other: Program, asked: Asked | None) -> bool:
    """Tell whether the other reading comes to the same, or to the same and more, in any order."""
    if asked is None:
        return set(one.facts) == set(other.facts) and one.answers == other.answers
    if asked.frame_after(one) != asked.frame_after(other) or bool(one.answers) != bool(
        other.answers
    ):
        return False
    if one.answers == other.answers:
        return True
    values = asked.values(other)
    return all(any(_same(value, each) for each in values) for value in asked.values(one))


_WORDS = Teller(Recording(rate_hz=1.0))
"""Writes the word that a value comes to; times in seconds of the recording."""


def _same(one: Value, other: Value) -> bool:
    """Tell whether two values say the same, amounts within their tolerance."""
    if isinstance(one, Amount) and isinstance(other, Amount):
        return one.amount.is_near(other.amount)
    if isinstance(one, Remark) and isinstance(other, Remark):
        return (one.kind, one.topic) == (other.kind, other.topic)
    if isinstance(one, Unknown) or isinstance(other, Unknown):
        return getattr(one, "reason", None) == getattr(other, "reason", None)
    words = decided(one, _WORDS), decided(other, _WORDS)
    return None not in words and words[0] == words[1]


_MIRRORED, _HALF = Fact("mirrored"), Fact("turned", "half")
_MAY_BE: dict[str, list[tuple[Fact, ...]]] = {
    name: [(Fact(name, denied=True),), *((Fact(name, each),) for each in FACTS[name][0])]
    for name in ("turned", "thread", "side")
} | {"mirrored": [(Fact("mirrored", denied=True),), (_MIRRORED,), (_MIRRORED, _HALF)]}
"""What a fact that was not understood may be; a mirror may lie across or along."""


def _matters(topics: Sequence[str], program: Program, asked: Asked | None) -> bool:
    """Tell whether an answer depends on facts that were not understood."""
    if asked is None or not program.answers or not set(topics) <= _MAY_BE.keys():
        return True
    possible = [
        asked.values(
            replace(program, facts=(*program.facts, *(fact for facts in each for fact in facts)))
        )
        for each in product(*(_MAY_BE[topic] for topic in topics))
    ]
    return not all(
        first.is_known and _same(first, other)
        for values in possible
        for first, other in zip(possible[0], values, strict=True)
    )


def _asked_back(program: Program, rival: Program | None) -> str:
    """Return one short question between two readings; what both state alike is left out."""
    if rival is not None and set(rival.facts) == set(program.facts):
        program, rival = replace(program, facts=()), replace(rival, facts=())
    words = [restated(each) for each in (program, rival) if each is not None]
    if sum(len(each.split()) for each in words) > MOST_OFFERED:
        words = words[:1]
    if len(words[0].split()) > MOST_OFFERED:
        return replies()["unclear_question"]
    if len(set(words)) == 1:
        return f"I am not sure what you ask; do you mean {words[0]}?"
    return f"Do you mean {words[0]}, or {words[1]}?"


# Evaluate


@dataclass(frozen=True)
class Asked:
    """The recordings that are asked about, and what held before the question.

    Args:
        bundle: The model.
        clips: One, or two that follow each other; the last is the one asked about.
        frame: What held before.
        named: The point of view that was named last, in words.
    """

    bundle: Bundle
    clips: tuple[Encoded, ...]
    frame: FrameSpec
    named: str | None = None

    @cached_property
    def evidence(self) -> tuple[Evidence, ...]:
        """What answers rest on; clips that are compared are independent."""
        return tuple(evidence_of(clip, seed) for seed, clip in enumerate(self.clips))

    def values(self, program: Program) -> tuple[Value, ...]:
        """Return what everything that is asked comes to, or why it is withheld."""
        values = answers(program, self.evidence, self.frame)
        return tuple(told_or_not(each, self.clips, self.bundle) for each in values)

    def frame_after(self, program: Program) -> FrameSpec:
        """Return the frame in which what was stated holds; the one before if it cannot."""
        try:
            return with_facts(self.frame, program.facts, self.clips[-1].clip.frames.shape[2])
        except UsageError:  # no camera has such pixels: the values say so
            return self.frame


def respond(asked: Asked, question: str, before: Program | None = None) -> Answer:
    """Answer a question.

    Args:
        asked: About what.
        question: As it was typed.
        before: What was asked last.

    Raises:
        UsageError: If the question is empty or too long.
    """
    understood = understand(asked.bundle.reader, question, before, asked)
    return answer(asked, understood)


# Tell


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


def _told(asked: Asked, understood: Understood, plain: Answer) -> Answer:
    """Word what everything that is asked comes to."""
    program, frame = understood.program, plain.frame
    values = asked.values(program)
    evidence = asked.evidence[-1]
    recording = evidence.recording.at_rate(frame.rate_hz, overrides=len(asked.clips) == 1)
    teller = Teller(recording, frame, asked.named)
    if program.form in TEMPLATES:  # what a program reads holds no guess
        values = tuple(_without_guesses(each, understood.probability) for each in values)
    sure = understood.probability * min(each.probability for each in values)
    is_talk = all(isinstance(each, Remark) for each in values)
    guess = any(map(is_guess, values))
    wording = worded(values, program.form, teller, sure)
    text = wording.text
    if head_of(program.answers[0]).word in ("why", "why-of"):
        text = " ".join([*evidence.reasons, f"Therefore: {text[:1].lower()}{text[1:]}"])
    text = _framed(text, understood, min(each.probability for each in values) if guess else None)
    # Below one half, the reading included, nothing is decided, though it is told.
    is_abstained = guess or sure < LEAST_SURE or any(not each.is_known for each in values)
    is_abstained |= any(getattr(each, "kind", "") in SILENT for each in values)
    first = values[0]
    encoded = looked_at(first, asked.clips)[-1]
    return replace(
        plain,
        text=text,
        kind=type_of(program.answers[0]),
        notes=(*plain.notes, *_notes(values, recording, evidence)),
        abstained=is_abstained,
        confidence=0.0 if is_abstained else sure,
        direction=None if is_abstained or is_talk else _direction(first),
        decided=None if is_abstained else decided(first, teller),
        options=_options(first, encoded),
        amount=_amount(first),
        motion=MeasuredMotion.of(encoded.belief.seen(first.edit), recording, frame),
        point_of_view=wording.named,
        values=values,
    )


def _framed(text: str, understood: Understood, chance: float | None) -> str:
    """Return an answer with how its question was taken, and as a guess where it is one.

    What fills a template stays as it is.
    """
    if understood.program.form in TEMPLATES:
        return text
    if chance is not None:
        text = f"I cannot tell for sure, {chance:.0%}: {text[:1].lower()}{text[1:]}"
    program = understood.program
    if understood.probability < PLAIN and program.form == "sentence" and not is_plain(program):
        return f"Taken as: {restated(program)}. {text}"
    return text


def _without_guesses(value: Value, understood: float) -> Value:
    """Return a value with nothing in the place of what is more likely wrong than right."""
    if isinstance(value, Record):
        fields = tuple((key, _without_guesses(each, understood)) for key, each in value.fields)
        return replace(value, fields=fields)
    is_unsure = is_guess(value) or understood * value.probability < LEAST_SURE
    return Unknown(of=value.of, reason="unsure", edit=value.edit) if is_unsure else value


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
    return (*notes, f"Pixels are those of the {size} frames; tell the mm per pixel to have mm.")


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
