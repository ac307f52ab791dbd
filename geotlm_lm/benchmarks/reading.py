"""Understanding: whether the right program is read, and how often the model itself answers."""

from __future__ import annotations

import random
from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import islice
from typing import NamedTuple

import numpy as np

from geotlm_lm.benchmarks.cases import simulated_mixtures
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, whole
from geotlm_lm.benchmarks.judging import share_row, share_rows
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.twist import COMPONENTS, WAYS, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.answers import answers
from geotlm_lm.query.copied import copied
from geotlm_lm.query.evaluate import ContactArea, Evidence
from geotlm_lm.query.follow_up import resumed
from geotlm_lm.query.lines import read
from geotlm_lm.query.phrases import label_of
from geotlm_lm.query.program import LEANING, Program, asks_of_two, filled, head_of, type_of
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.reader import Reader, Reading
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Measure,
    Moved,
    Placed,
    Record,
    Recording,
    Remark,
    Times,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.query.worlds import worlds_of_track
from geotlm_lm.track.events import COMPONENT_OF, Event, EventKind, Span
from geotlm_lm.track.summed import belief_of_track
from geotlm_lm.track.track import Track
from geotlm_lm.training.calibration import expected_calibration_error
from geotlm_lm.training.forms import formed
from geotlm_lm.training.grammar import corpus, grammar
from geotlm_lm.training.labelled import (
    BLIND,
    KEPT,
    SET_UPS,
    TUNE,
    WRITERS,
    Labelled,
    labelled,
    of_pairs,
    written_by,
)

PROGRAM, VALUE, SEEN = "right program", "right value", "of families trained on"
SURE, PAIRS, SEEN_PAIRS = 0.8, 2000, 40_000

EACH = 20
"""Questions read of each primitive, at most."""

OWN, CLIPS, OWN_EACH = "said by the model itself", 150, 10
"""Name of a row, simulated clips, and questions about each."""

RECORDINGS, STEP_S = 50, 0.04
HELD = 0.3
"""Share of recordings that end in contact."""

FRAMES = (FrameSpec(), FrameSpec(thread="right", contact_side="head", mm_per_px=0.08))
"""What is known of the set-up, in turn: nothing, and whatever an answer may lack."""

_LEGS = ("turn", "slide", "press", "release", "stick")

BEFORE = read("way turn")
"""What is taken to have been asked before a question that leans on another."""


def _reading_rows(run: Run) -> Iterator[Row]:
    some, pairs = run.size(10_000, 40), grammar().pairs(run.seed, "test")
    forms = formed(random.Random(run.seed), "test")
    sets = {
        "grammar, families held out": of_pairs(islice(pairs, run.size(PAIRS, 60))),
        "corpus, families held out": of_pairs(corpus("test"))[:some],
        "output forms, layouts held out": of_pairs(islice(forms, run.size(PAIRS // 4, 40))),
        "blind": labelled(BLIND)[:some],
        "set-ups": labelled(SET_UPS)[:some],
        "tune": labelled(TUNE)[:some],
        "askers, meanings held out": labelled(KEPT)[:some],
    }
    for writer in WRITERS:
        asked = of_pairs(written_by(writer, run.seed))
        sets[f"{writer} writer"] = asked[:: run.size(1, 20)]
    for name, questions in sets.items():
        run.progress(f"reading, {name}", 0, 1)
        graded = [grade(question, run.answerer.bundle.reader) for question in questions]
        yield from graded_rows(name, graded, run.seed)
        for cause in sorted({each.cause for each in graded}) if name.endswith("writer") else ():
            own = [each for each in graded if each.cause == cause]
            yield from graded_rows(f"{name}, {cause}", own, run.seed)
    yield from _seen_rows(run)


class Graded(NamedTuple):
    """A question's family of phrasing ("": its own), how sure its reading is, and what is right."""

    family: str
    probability: float
    program: bool
    value: bool

    @property
    def cause(self) -> str:
        """What makes it hard: the kind that its family is of."""
        return self.family.partition("/")[0]


def grade(question: Labelled, reader: Reader) -> Graded:
    """Return whether the right program is read, or another that comes to the same."""
    reading = reader.read(question.text)
    is_met = question.is_met(reading.line)
    is_same = is_met or _comes_to_it(question, reading)
    return Graded(question.family, reading.probability, is_met, is_same)


def graded_rows(name: str, graded: Sequence[Graded], seed: int) -> Iterator[Row]:
    """Yield the shares of right programs and of right values, whole families resampled."""
    families = [each.family or str(place) for place, each in enumerate(graded)]
    exact = [each.program for each in graded]
    detail = _doubt(np.array([each.probability for each in graded]), np.array(exact))
    yield share_row(name, PROGRAM, exact, families, seed, detail=detail)
    yield share_row(name, VALUE, [each.value for each in graded], families, seed)


def _comes_to_it(question: Labelled, reading: Reading) -> bool:
    """Whether what was read comes to the same as what was meant."""
    got = resumed(reading.program, BEFORE)
    numbers = quantities(question.text)
    # Those of the text as it was typed: mending a slip may change which words there are.
    words = tuple(each.text for each in copied(question.text))
    meant = (filled(read(line), numbers, words) for line in question.queries)
    return any(come_to_the_same(got, resumed(each, BEFORE)) for each in meant)


def _seen_rows(run: Run) -> Iterator[Row]:
    """Yield what is read of families that were trained on, by primitive."""
    cells: dict[str, list[bool]] = defaultdict(list)
    pairs = islice(grammar().pairs(run.seed + 1, "train"), run.size(SEEN_PAIRS, 500))
    run.progress("reading, seen families", 0, 1)
    for question in of_pairs(pairs):
        cell = cells[primitive_of(question.queries[0])]
        if len(cell) < run.size(EACH, 1):
            cell.append(question.is_met(run.answerer.bundle.reader.read(question.text).line))
    for word, exact in sorted(cells.items()):
        yield Row(word, SEEN, len(exact), 1 - sum(exact) / len(exact))


def primitive_of(line: str) -> str:
    """Return the word of what a program asks first, without what stands around it, or "fact"."""
    answers = read(line).answers
    return head_of(answers[0]).word if answers else "fact"


def _doubt(sure: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    is_sure = sure >= SURE
    return {
        "mean_stated": float(sure.mean()),
        "calibration_error": expected_calibration_error(sure, exact),
        "sure": float(is_sure.mean()),
        "sure_and_wrong": float((is_sure & ~exact).sum() / max(is_sure.sum(), 1)),
    }


_DOUBT = {
    "questions": "case",
    "read": "count",
    "right": "right:.3f",
    "mean stated": "mean_stated:.3f",
    "calibration error": "calibration_error:.3f",
    "read with 0.8 or more": "sure:.3f",
    "wrong of these": "sure_and_wrong:.3f",
}

READING = Section(
    name="reading",
    title="Understanding",
    about="""\
Each question is read into a program. The *right program* is the one meant in every word, but for
the order of facts and of what stands in any order, and degrees, in which angles are told anyway;
the *right value* is that of a program which states the same and comes to the same on 50 recordings
that are made up, whatever its form. Families of phrasing, and their clauses, were kept from
training. The *blind* questions, and the *set-ups* that state one to five facts in several
sentences, were written by people who had seen no template and no rule, and nothing was chosen by
them; readers were chosen and calibrated by the *tune* questions, written so too, and chosen by what
*askers* labelled themselves, of which all that mean one thing were kept from training. All that two
*writers* ask was kept from training, and is told apart by what makes it hard as well. Intervals
resample whole families.""",
    shares=whole(_reading_rows),
    views={
        "": Pivot(
            right_with_interval, "questions", shows=lambda row: row.variant in (PROGRAM, VALUE)
        ),
        "Families that were trained on, by primitive": Pivot(
            "right:.2f", "primitive", shows=lambda row: row.variant == SEEN
        ),
        "Doubt": Listing(_DOUBT, lambda row: row.variant == PROGRAM),
    },
)


def _own_rows(run: Run) -> Iterator[Row]:
    graded = []
    questions = _questions(run.seed)
    clips = run.size(CLIPS, 2)
    for place, made in enumerate(simulated_mixtures(clips, run.seed)):
        run.progress("own answers", place, clips)
        try:
            encoded = run.answerer.encode(made.clip)
        except UnreadableClip:
            continue
        for question in islice(questions, OWN_EACH):
            reply = run.answerer.ask(encoded, question)
            if reply.values and not reply.withheld:
                is_own = reply.told_by == "model"
                graded += [(case, OWN, is_own, made.object_name) for case in ("all", reply.kind)]
    yield from sorted(share_rows(graded, run.seed), key=lambda row: row.case)


def _questions(seed: int) -> Iterator[str]:
    """Yield questions about one clip, of families kept from training."""
    for pair in grammar().pairs(seed, "test"):
        answers = read(pair.query).answers
        words = {each.word for answer in answers for each in answer}
        leans = words & {*LEANING, "again", "plain", "talk", "not-understood"}
        if answers and not leans and not any(map(asks_of_two, answers)):
            yield pair.text


OWN_ANSWERS = Section(
    name="own-answers",
    title="What the language model says itself",
    about="""\
Every answer follows from values. It is the language model's own where the model, given its tactile
prefix, the question and the program, says the same sentence word for word; numbers are copied from
the value. Where a value is withheld in a form that programs read, its place is empty: such an
answer is nobody's and not counted. Clips are simulated and turn, slide and press at once, objects
and families of phrasing are kept from training. What the model feels at its slots stands beside
probe and rivals above.""",
    shares=whole(_own_rows),
    views={"": Pivot(right_with_interval, "kind of answer")},
)


def come_to_the_same(one: Program, other: Program) -> bool:
    """Tell whether two programs state the same and come to the same on every made recording.

    Args:
        one: With its numbers and words, and what it leans on spelled out.
        other: Likewise.
    """
    if set(one.facts) != set(other.facts) or len(one.answers) != len(other.answers):
        return False
    return one.answers == other.answers or all(
        all(map(is_same, answers(one, clips, frame), answers(other, clips, frame)))
        for clips, frame in _made()
    )


def is_same(one: Value, other: Value) -> bool:
    """Tell whether two values say the same: amounts within their tolerance, times to a frame."""
    if type(one) is not type(other) or _asked(one) != _asked(other):
        return False
    match one:
        case Unknown():
            return one.reason == other.reason
        case Truth():
            return one.holds == other.holds
        case Amount():
            return one.amount.is_near(other.amount)
        case Times():
            times = one.times_s, other.times_s
            return len(times[0]) == len(times[1]) and np.allclose(*times, rtol=0, atol=STEP_S)
        case Moved():
            pairs = zip(one.movements, other.movements, strict=False)
            return _ways(one) == _ways(other) and all(
                _is_near(a.amount, b.amount) for a, b in pairs
            )
        case Choice():
            return _chosen(one) == _chosen(other)
        case Record():
            return [key for key, _ in one.fields] == [key for key, _ in other.fields] and all(
                is_same(a, b) for (_, a), (_, b) in zip(one.fields, other.fields, strict=True)
            )
        case Placed():
            return (one.across, one.down, one.share) == (other.across, other.down, other.share)
        case Remark():
            return (one.kind, one.topic) == (other.kind, other.topic)
    raise TypeError(f"no value: {one!r}")


def _asked(value: Value) -> tuple[str, str]:
    """Return the type of what is asked, and its word where another tells the same otherwise."""
    kind = type_of(value.of)
    return kind, head_of(value.of).word if kind in ("way", "talk") else ""


def _is_near(one: Measure | None, other: Measure | None) -> bool:
    return one is other if one is None or other is None else one.is_near(other)


def _ways(value: Moved) -> tuple[object, ...]:
    moves = [(move.way, move.aslant) for move in value.movements]
    happened = [(each.kind, each.way, each.begin_s, each.end_s) for each in value.shown]
    story = happened if head_of(value.of).word == "story" else []
    return moves, set(value.denied), value.still_axis, value.rest, value.tightens, story


def _chosen(value: Choice) -> set[str | int]:
    head = head_of(value.of)
    if head.word in ("choose", "choose-not"):
        return {label_of(head.arguments[0][place]) for place in value.chosen}
    return set(value.chosen)


@lru_cache(maxsize=1)
def _made() -> tuple[tuple[tuple[Evidence, Evidence], FrameSpec], ...]:
    """Return each recording behind the one before it, and what is known of its set-up."""
    made = [_evidence(place) for place in range(RECORDINGS)]
    pairs = zip([made[-1], *made], made, strict=False)
    return tuple((pair, FRAMES[place % len(FRAMES)]) for place, pair in enumerate(pairs))


def _evidence(seed: int) -> Evidence:
    rng = generator_for(seed, "meanings")
    track = made_track(rng)
    ways = dict.fromkeys((way for ways in WAYS.values() for way in ways), 0.0)
    readable = dict.fromkeys(COMPONENTS, True)
    belief = belief_of_track(track, Belief(Twist(), 0.1 * np.eye(4), ways, 1.0, 30.0, readable))
    rows, columns = track.frame_size
    recording = Recording(columns, rows, 1 / STEP_S, len(track), step_s=STEP_S)
    area = ContactArea(*rng.uniform(0.2, 0.8, 2), rng.uniform(0.05, 0.3))
    return Evidence(worlds_of_track(track, belief, seed), recording, area)


def made_track(rng: np.random.Generator) -> Track:
    """Return a recording of 25 frames a second, touched once or twice, with a few motions each."""
    events: list[Event] = []
    touched: list[tuple[int, int]] = []
    at = int(rng.integers(5, 25))
    for _ in range(int(rng.integers(1, 3))):
        begin = at
        events.append(_event(rng, "touch", at, at))
        for kind in rng.choice(_LEGS, int(rng.integers(1, 6))):
            length = int(rng.integers(8, 40))
            events.append(_event(rng, str(kind), at, at + length))
            at += length + int(rng.integers(0, 8))
        events.append(_event(rng, "release", at, at))
        touched.append((begin, at))
        at += int(rng.integers(10, 30))
    if rng.random() < HELD:
        at = events.pop().end
    count = at + 1
    twists, contact = np.zeros((count, 4)), np.full(count, 0.01)
    for begin, end in touched:
        contact[begin : end + (end == at)] = 0.99
    for event in events:
        steps = rng.uniform(0.2, 1.0, event.end - event.begin)
        way = event.twist
        far = np.array([way.turn_deg, way.right_px, way.down_px, way.inward_mm])
        twists[event.begin + 1 : event.end + 1] += np.outer(steps / max(steps.sum(), 1e-9), far)
    return Track(
        numbers=np.arange(count),
        times_s=np.arange(count) * STEP_S,
        contact=contact,
        strength_grey=5.0 * contact,
        twists=twists,
        covariances=np.tile(1e-4 * np.eye(4), (count, 1, 1)),
        radius_px=np.full(count, 50.0),
        turn_shares=np.full(count, 0.16),
        events=tuple(events),
        frame_size=(240, 320),
    )


def _event(rng: np.random.Generator, name: str, begin: int, end: int) -> Event:
    """Return a motion, a touch or a rest between two frames; its way and its length are drawn."""
    kind, sign = EventKind(name), rng.choice([-1, 1])
    angle, far = rng.integers(8) * np.pi / 4, rng.uniform(5, 40)
    twist, amount = {
        "turn": (Twist(turn_deg=sign * 2 * far), sign * 2 * far),
        "slide": (Twist(right_px=far * np.cos(angle), down_px=far * np.sin(angle)), far),
        "press": (Twist(inward_mm=far / 40), far / 40),
        "release": (Twist(inward_mm=-far / 40), -far / 40),
    }.get(name, (Twist(), 0.0))
    span, sure = Span(amount, 0.08 * abs(amount)), rng.uniform(0.7, 0.99)
    times_s = begin * STEP_S, end * STEP_S
    return Event(kind, begin, end, *times_s, twist, span, sure, COMPONENT_OF.get(kind))
