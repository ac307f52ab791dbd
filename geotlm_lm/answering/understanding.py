"""From a question to the program that it is taken for, or to what is asked back.

The likeliest reading is taken, where likelier than all others or where likely ones come to the
same; it is asked back only between close readings that come to different values.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import Evidence, with_facts
from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.lines import FACTS, write
from geotlm_lm.query.phrases import is_refused, is_talk, replies, restated
from geotlm_lm.query.program import (
    LEANING,
    TWO_CLIPS,
    Expression,
    Fact,
    Program,
    head_of,
    is_void,
    leans,
    words_of,
)
from geotlm_lm.query.reader import Reader, Reading
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Placed,
    Record,
    Recording,
    Remark,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.query.written import decided

LEAST_SURE = 0.5
"""Probability below which an answer is only a guess: it would more likely be wrong than right."""

READ = 0.7
"""Least probability of a condition's reading: it moves a robot, as facts turn a direction."""

IS_SO = "Is this so: {}?"
"""Makes a question of a condition."""

OF_CONTACT = frozenset({"touch", "none", "press", "in", "out"})
"""Words of a program that ask whether, or how deep, something touches."""

_OF_MOTION = frozenset({"move", "turn", "slide"})


def told_or_not(value: Value, clips: tuple[Encoded, ...], bundle: Bundle) -> Value:
    """Return a value, or why the recording that it is of does not tell it.

    Args:
        value: What was asked comes to.
        clips: One, or two that follow each other.
        bundle: Knows how much contact each direction needs.
    """
    if isinstance(value, Record):
        fields = ((key, told_or_not(each, clips, bundle)) for key, each in value.fields)
        return replace(value, fields=tuple(fields))
    if isinstance(value, Unknown) and value.supposing is not None:
        # What is withheld, or a guess, is not told of a supposed thread either.
        supposing = told_or_not(value.supposing, clips, bundle)
        if not supposing.is_known:
            return supposing
        return replace(value, supposing=None) if is_guess(supposing) else value
    for encoded in looked_at(value, clips):
        reason, detail = _why_withheld(value, encoded, bundle)
        if reason is not None:
            return Unknown(of=value.of, reason=reason, detail=detail, edit=value.edit)
    return value


def is_guess(value: Value, understood: float = 1.0) -> bool:
    """Tell whether a value is more likely wrong than right, its reading's probability included."""
    if isinstance(value, Record):
        return any(is_guess(each, understood) for _, each in value.fields)
    is_asked_for = head_of(value.of).word in ("why", "sure", "alternatives", "why-of", "sure-of")
    return value.is_known and not is_asked_for and understood * value.probability < LEAST_SURE


def looked_at(value: Value, clips: tuple[Encoded, ...]) -> tuple[Encoded, ...]:
    """Return the clips that a value tells of."""
    if len(clips) == 1:
        return clips
    words = {each.word for each in value.of}
    firsts = words & {"of-first", "of-previous"}
    if value.clip == "first" or (firsts and value.of.word in firsts):
        return clips[:1]
    return clips if words & set(TWO_CLIPS) or firsts else clips[-1:]


def _why_withheld(value: Value, encoded: Encoded, bundle: Bundle) -> tuple[str | None, str]:
    """Return the name of a reason of `replies.toml`, and what it says besides."""
    if isinstance(value, Remark):
        return None, ""
    if encoded.suspicion:
        return "suspicion", encoded.suspicion
    if not value.is_known:
        return None, ""
    words, motion = set(_words(value)), value.moved
    moves = () if motion is None else motion.movements
    rest = None if motion is None else motion.rest
    is_of_contact = isinstance(value, Placed) or not words.isdisjoint(OF_CONTACT)
    is_pressed = any(move.component is Component.PRESS for move in moves)
    # What turns or slides touches, whether or not the untouched gel is known.
    is_moving = any(encoded.belief.moves(part) >= 0.5 for part in (Component.TURN, Component.SLIDE))
    is_touch = isinstance(value, Truth) and value.of.word == "touch" and is_moving
    if not encoded.is_contact_known and (is_of_contact or is_pressed) and not is_touch:
        is_rest = not is_moving and words <= {"touch", "none"}
        return ("reference" if is_rest else "contact"), ""
    is_directed = any(move.way in DIRECTED for move in moves)
    is_faint = encoded.contact_share < bundle.calibration.contact_threshold
    if encoded.track is None and is_directed and is_faint:
        return "mask", f"(mask {encoded.contact_share:.3f})."
    # Contact is not judged without an image of the idle gel; that nothing moves is told.
    is_lacking = encoded.is_static if encoded.is_contact_known else not is_touch
    is_of_motion = isinstance(value, Truth) and words and words <= _OF_MOTION
    if is_lacking and not is_of_motion and (rest is not None or words & {"touch", "none"}):
        return "reference", ""
    # What changes a recording in which a touch is recognised is that touch.
    is_denied = isinstance(value, Truth) and value.of.word == "touch" and not value.holds
    is_unexplained = encoded.is_changed and encoded.belief.contact < LEAST_SURE
    is_wrong = is_unexplained and (is_denied or rest is Motion.NONE)
    return ("unrecognised" if is_wrong else None), ""


def _words(value: Value) -> Iterator[str]:
    """Yield what a program speaks of; of options those that hold, not what else was offered."""
    asked: tuple[Expression, ...] = (value.of,)
    head = head_of(value.of)
    if isinstance(value, Choice) and value.chosen and head.word in ("choose", "choose-not"):
        asked = tuple(head.arguments[0][place].holds for place in value.chosen)
    for expression in asked:
        yield from words_of(expression)


UNSOUND = ("unit", "before")
"""Reasons for which no recording would answer a question, whatever else were stated."""


def is_sound(values: Sequence[Value]) -> bool:
    """Tell whether what was asked could be answered of some recording."""
    return not values or any(getattr(each, "reason", None) not in UNSOUND for each in values)


STATED = ("scale", "rate", "thread")
"""Reasons for which a question waits for a fact that can be stated."""


def lacking(values: Sequence[Value]) -> list[Value | None]:
    """Return what each value that waits for a fact is supposed to be, None where that is open."""
    lacks: list[Value | None] = []
    for value in values:
        if isinstance(value, Record):
            lacks += lacking([each for _, each in value.fields])
        elif isinstance(value, Unknown) and value.reason in STATED:
            lacks.append(value.supposing)
    return lacks


@dataclass(frozen=True)
class Asked:
    """The recordings that are asked about, and what held before the question.

    Args:
        bundle: The model.
        clips: One, or two that follow each other; the last is the one asked about.
        frame: What held before.
        named: The point of view that was named last, in words.
        known_values: What programs came to: readings that are compared are evaluated once.
    """

    bundle: Bundle
    clips: tuple[Encoded, ...]
    frame: FrameSpec
    named: str | None = None
    known_values: dict[Program, tuple[Value, ...]] = field(init=False, default_factory=dict)

    @cached_property
    def evidence(self) -> tuple[Evidence, ...]:
        """What answers rest on; clips that are compared are independent."""
        return tuple(clip.evidence_by(seed) for seed, clip in enumerate(self.clips))

    def says(self, question: str, written: str, text: str) -> bool:
        """Tell whether an answer is what the language model itself says; it sees one clip."""
        if len(self.clips) > 1:
            return False
        return self.bundle.speaker.says(self.clips[-1].prefix, question, written, text)

    def values(self, program: Program) -> tuple[Value, ...]:
        """Return what everything that is asked comes to, or why it is withheld."""
        if program not in self.known_values:
            values = answers(program, self.evidence, self.frame)
            values = tuple(told_or_not(each, self.clips, self.bundle) for each in values)
            self.known_values[program] = values
        return self.known_values[program]

    def frame_after(self, program: Program) -> FrameSpec:
        """Return the frame in which what was stated holds; the one before if it cannot."""
        try:
            return with_facts(self.frame, program.facts, self.clips[-1].clip.frames.shape[2])
        except UsageError:  # no camera has such pixels: the values say so
            return self.frame


UNDERSTOOD = 0.5
"""Probability of a reading from which on it is likelier than all others together."""

UNLIKELY = 0.3
"""Probability below which the likeliest reading is asked back about whatever others there are: of
48 such questions of `tune` it was right in 8, of 97 read with 0.3 to 0.5 in 42."""

CLOSE = 0.8
"""Share of the likeliest reading's probability from which on another one is asked back about."""

OF_TWO = frozenset({*TWO_CLIPS, "of-first", "of-second", "of-previous"})
OF_BEFORE = frozenset({*LEANING, "again", "plain"})
"""Words of programs that are out of place where one recording is open, or nothing was asked."""

NAMELESS = 0.5
"""What a reading counts that names none of two open recordings, beside one that does: "the first
one" is a recording as often as a turn."""

MOST_OFFERED = 30
"""Words of what was understood beyond which nobody would read it: what is asked back is short."""

UNDERSTOOD_FACTS = 0.7
"""Probability below which facts that would turn an answer are asked back about: they hold until
they are taken back."""


@dataclass(frozen=True)
class Understood:
    """What a question was taken to ask.

    Args:
        program: With its numbers and words, and what it leans on spelled out.
        probability: That this is what was meant.
        ask_back: What is asked where two readings are close, or a fact was not understood.
        notes: Which facts were not understood and change nothing.
        milliseconds: That reading took.
        question: As it was typed.
        written: The program as the model wrote it, numbers and copied words as slots.
        is_resumed: Whether only the facts are of this question, and what waited for them is asked.
    """

    program: Program
    probability: float
    ask_back: str | None = None
    notes: tuple[str, ...] = ()
    milliseconds: float = 0.0
    question: str = ""
    written: str = ""
    is_resumed: bool = False

    @property
    def line(self) -> str:
        """The program in its words."""
        return write(self.program)


def understand(
    reader: Reader,
    question: str,
    before: Program | None = None,
    asked: Asked | None = None,
    *,
    is_condition: bool = False,
) -> Understood:
    """Read a question.

    Args:
        reader: The model that reads.
        question: As it was typed.
        before: What was asked last, if anything was.
        asked: About what: readings are compared by what they come to; None where the program
            itself is wanted.
        is_condition: Whether it is one, read as the question whether it is so where it is not sure.

    Raises:
        UsageError: If the question is empty or too long.
    """
    started = time.perf_counter()
    unlikely = OF_TWO | OF_BEFORE if is_condition else frozenset()
    if asked is not None and len(asked.clips) < 2:
        unlikely |= OF_TWO
    if asked is not None and (before is None or not before.answers):
        unlikely |= OF_BEFORE
    read = partial(_of_condition, reader) if is_condition else reader.readings
    readings = read(question, unlikely=unlikely)
    if asked is not None and len(asked.clips) > 1:
        readings = _naming_first(readings)
    understood = _chosen(reader, readings, before or Program(), asked)
    took = 1e3 * (time.perf_counter() - started)
    return replace(understood, milliseconds=took, question=question)


def with_waiting(understood: Understood, before: Program, sure: float, asked: Asked) -> Understood:
    """Return what was understood, with what was asked before where that waited for a fact in it.

    Args:
        understood: What is said now.
        before: What was asked last.
        sure: How probable it is that that was meant.
        asked: About what.
    """
    program = replace(before, facts=understood.program.facts)
    is_fact = understood.ask_back is None and program.facts and not understood.program.answers
    if not is_fact or asked.frame_after(program) == asked.frame:
        return understood
    lacks = lacking(asked.values(replace(before, facts=())))
    if not lacks or lacking(asked.values(program)) == lacks:
        return understood
    probability = sure * understood.probability
    return replace(understood, program=program, probability=probability, is_resumed=True)


def _of_condition(reader: Reader, text: str, unlikely: frozenset[str]) -> list[Reading]:
    """Return the readings of a condition, or of the question whether it is so.

    The reader knows questions best: "it has turned 90 degrees" alone may speak of the camera.
    """
    readings = reader.readings(text, unlikely=unlikely)
    if readings[0].probability >= READ and readings[0].program.answers:
        return readings
    asked = reader.readings(IS_SO.format(text.strip().rstrip(".?!")), unlikely=unlikely)
    return max(
        readings, asked, key=lambda each: each[0].probability * bool(each[0].program.answers)
    )


def _chosen(
    reader: Reader, readings: Sequence[Reading], before: Program, asked: Asked | None
) -> Understood:
    """Return the likeliest reading, those that come to the same values counted together."""
    readings = [each for each in readings if not is_void(each.program)] or readings
    programs = [_resumed(each.program, before) for each in readings]
    groups: list[list[int]] = []
    for place, program in enumerate(programs):
        for group in groups:
            if _agree(programs[group[0]], program, asked):
                group.append(place)
                break
        else:
            groups.append([place])
    chances = [sum(readings[place].chance for place in group) for group in groups]
    chances = _of_open(reader, chances, [programs[group[0]] for group in groups], asked)
    best = max(range(len(groups)), key=chances.__getitem__)
    program = programs[groups[best][0]]
    written = readings[groups[best][0]].line
    understood = Understood(program, reader.calibrated(chances[best]), written=written)
    others = sorted(set(range(len(groups))) - {best}, key=lambda place: -chances[place])
    rival = programs[groups[others[0]][0]] if others else None
    is_close = bool(others) and chances[others[0]] >= CLOSE * chances[best]
    unclear = [fact.value for fact in program.facts if fact.name == "unclear"]
    if unclear and _matters(unclear, program, asked):
        return replace(understood, ask_back=replies()["unclear"][unclear[0]])
    if unclear:
        notes = tuple(replies()["unclear_same"][each] for each in unclear)
        understood = replace(understood, notes=notes)
    is_unsure = understood.probability < (UNDERSTOOD if is_close else UNLIKELY)
    is_doubtful = is_unsure and not is_talk(program)
    if program.facts and understood.probability < UNDERSTOOD_FACTS:
        # Facts that may not have been stated would hold from now on.
        is_doubtful |= rival is None or set(rival.facts) != set(program.facts)
    rival = rival if is_close or program.facts else None
    return replace(understood, ask_back=_asked_back(program, rival)) if is_doubtful else understood


def _of_open(
    reader: Reader, chances: list[float], programs: Sequence[Program], asked: Asked | None
) -> list[float]:
    """Return the chances of readings without those of two recordings where one is open.

    Those stay where one is surely meant, or no other is likely.
    """
    is_of_two = [_asks_of_two(each) and asked is not None and len(asked.clips) < 2
                 for each in programs]  # fmt: skip
    of_two = sum(chance for chance, is_so in zip(chances, is_of_two, strict=True) if is_so)
    likeliest = max(range(len(chances)), key=chances.__getitem__)
    is_sure = reader.calibrated(chances[likeliest]) >= UNDERSTOOD
    if is_sure or not is_of_two[likeliest]:
        return chances
    rest = [0.0 if is_so else chance / (1 - of_two)
            for chance, is_so in zip(chances, is_of_two, strict=True)]  # fmt: skip
    return rest if reader.calibrated(max(rest)) >= UNLIKELY else chances


def _naming_first(readings: Sequence[Reading]) -> Sequence[Reading]:
    """Return readings of two recordings, those that name none of them less likely."""
    weights = [1.0 if _asks_of_two(each.program) else NAMELESS for each in readings]
    if max(weights) == min(weights):
        return readings
    chances = [weight * each.chance for weight, each in zip(weights, readings, strict=True)]
    scale = sum(each.chance for each in readings) / sum(chances)
    weighed = (
        replace(each, chance=scale * chance) for each, chance in zip(readings, chances, strict=True)
    )
    return sorted(weighed, key=lambda each: -each.chance)


def _asks_of_two(program: Program) -> bool:
    return any(not OF_TWO.isdisjoint(each.word for each in answer) for answer in program.answers)


def _resumed(program: Program, before: Program) -> Program:
    """Return a program with what it leans on spelled out, which asks nothing twice."""
    if before.answers or leans(program):
        program = resumed(program, before)
    return replace(program, answers=tuple(dict.fromkeys(program.answers)))


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
        return one.kind == other.kind and (one.kind == "cannot" or one.topic == other.topic)
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
    # Nobody means to ask what cannot be told.
    words = [restated(each) for each in (program, rival) if each and not is_refused(each)]
    if not words:
        return replies()["unclear_question"]
    if sum(len(each.split()) for each in words) > MOST_OFFERED:
        words = words[:1]
    if len(words[0].split()) > MOST_OFFERED:
        return replies()["unclear_question"]
    if len(set(words)) == 1:
        return f"I am not sure what you ask; do you mean {words[0]}?"
    return f"Do you mean {words[0]}, or {words[1]}?"
