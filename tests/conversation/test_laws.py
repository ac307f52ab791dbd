"""Laws of what is asked: however a question is put, what it is told follows from one motion.

A scripted model feels one motion whatever it is asked; frames, claims, denials, choices, mirrors,
doubts and facts are then all exact functions of that motion.
"""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion, mirror, reverse, turn_by_quarter
from geotlm_lm.core.twist import COMPONENT_OF, WAYS, Component
from tests.answering.scripted import believed, feeling, recording

drawn = settings(derandomize=True, max_examples=60, deadline=None, database=None)

CAMERA = FrameSpec()
OPEN = "Which way does it move?"
CLAIMED = {
    Motion.CLOCKWISE: "turning clockwise",
    Motion.COUNTERCLOCKWISE: "turning counterclockwise",
    Motion.LEFT: "sliding left",
    Motion.RIGHT: "sliding right",
    Motion.UP: "sliding up",
    Motion.DOWN: "sliding down",
}
FACTS = {
    "The image is mirrored.": {"image_mirrored": True},
    "I look from the object's side.": {"viewpoint": "object"},
    "The sensor moved, not the object.": {"actor": "sensor"},
    "The image is upside down.": {"image_upside_down": True},
}
UNDONE = {
    "The image is mirrored.": "The image is not mirrored.",
    "I look from the object's side.": "I look from the sensor's side.",
    "The sensor moved, not the object.": "The object moved, not the sensor.",
    "The image is upside down.": "The image is upright.",
}
DOUBTS = ("Are you sure?", "Really?", "no way", "That's wrong", "You are wrong, look again!", "No.")

motions = st.sampled_from(DIRECTED)
facts = st.lists(st.sampled_from(sorted(FACTS)), unique=True, max_size=4)
turns = st.sampled_from([None, "clockwise", "counterclockwise"])
frames = st.builds(
    FrameSpec,
    image_mirrored=st.booleans(),
    viewpoint=st.sampled_from(["sensor", "object"]),
    actor=st.sampled_from(["object", "sensor"]),
    image_quarter_turn=turns,
)


@st.composite
def _states(draw):
    """Up to three ways that count, the larger first, of one component each."""
    ways = [draw(st.sampled_from(WAYS[one])) for one in draw(st.permutations(list(Component)))]
    return tuple(ways[: draw(st.integers(1, 3))])


states = _states()


class Feelings:
    """A clip and, by motion, the answerer that feels it."""

    def __init__(self, bundle):
        self.answerers = {motion: feeling(bundle, motion) for motion in Motion}
        self.encoded = self.answerers[Motion.STILL].encode(recording())

    def ask(self, motion, question, frame=CAMERA):
        return self.answerers[motion].ask(self.encoded, question, frame=frame)

    def session(self, motion):
        return self.answerers[motion].session(self.encoded)


class Mixtures:
    """A clip and, by the ways that count, the answerer that feels them."""

    def __init__(self, bundle):
        self.answerer = feeling(bundle, "left")
        self.encoded = self.answerer.encode(recording())

    def ask(self, ways, question, frame=CAMERA):
        self.answerer.belief = believed(*ways)
        encoded = replace(self.encoded, believe=None)
        return self.answerer.ask(encoded, question, frame=frame)


@pytest.fixture(scope="session")
def feelings(bundle):
    return Feelings(bundle)


@pytest.fixture(scope="session")
def feels(bundle):
    return Mixtures(bundle)


@given(motions, motions, frames)
@drawn
def test_claim_denial_and_open_question_agree(feelings, felt, claim, frame):
    told = feelings.ask(felt, OPEN, frame).direction
    assert told == frame.tell(felt)
    is_so = told == claim
    assert feelings.ask(felt, f"Is it {CLAIMED[claim]}?", frame).decided == _word(is_so)
    for denial in ("Is it not {}?", "Is it true that it is not {}?", "It is not {}, right?"):
        denied = feelings.ask(felt, denial.format(CLAIMED[claim]), frame)
        assert denied.decided == ("it is" if is_so else "it is not")


@given(motions, frames, st.permutations(sorted(CLAIMED)), st.integers(2, 6))
@drawn
def test_a_choice_names_the_option_of_the_open_answer(feelings, felt, frame, order, count):
    told = frame.tell(felt)
    offered = dict(zip("ABCDEF", order[:count], strict=False))
    question = " ".join(f"{letter}) {motion.value}" for letter, motion in offered.items())
    answer = feelings.ask(felt, question, frame)
    if told not in offered.values():
        assert answer.decided not in {f"{letter}) {one.value}" for letter, one in offered.items()}
        return
    letter = next(letter for letter, motion in offered.items() if motion == told)
    assert answer.decided == f"{letter}) {told.value}"
    assert sum(answer.options.values()) == pytest.approx(1.0)


@given(motions, frames)
@drawn
def test_a_mirrored_mirror_is_none_and_so_is_a_film_run_back_twice(feelings, felt, frame):
    mirrored, back = "And mirrored?", "And played backwards?"
    assert feelings.ask(felt, mirrored, frame).direction == frame.tell(mirror(felt))
    assert feelings.ask(mirror(felt), mirrored, frame).direction == frame.tell(felt)
    assert feelings.ask(felt, back, frame).direction == frame.tell(reverse(felt))
    assert feelings.ask(reverse(felt), back, frame).direction == frame.tell(felt)


@given(motions, frames)
@drawn
def test_what_undoes_a_motion_is_its_inverse_and_is_undone_by_it(feelings, felt, frame):
    undoes = feelings.ask(felt, "What undoes it?", frame).direction
    assert undoes == reverse(frame.tell(felt))
    assert feelings.ask(reverse(felt), "What undoes it?", frame).direction == frame.tell(felt)


@given(motions, st.permutations(sorted(FACTS)), st.integers(0, 4))
@drawn
def test_facts_compose_in_any_order_and_hold_as_if_given(feelings, felt, order, count):
    stated = order[:count]
    frame = CAMERA
    for fact in stated:
        frame = replace(frame, **FACTS[fact])
    given_ = feelings.ask(felt, OPEN, frame)
    said = feelings.ask(felt, " ".join((*stated, OPEN)))
    session = feelings.session(felt)
    for fact in stated:
        session.ask(fact)
    assert session.frame == frame
    assert session.ask(OPEN).text == said.text == given_.text
    assert said.direction == given_.direction == frame.tell(felt)


@given(motions, facts)
@drawn
def test_facts_taken_back_leave_no_trace(feelings, felt, stated):
    session = feelings.session(felt)
    first = session.ask(OPEN)
    for fact in stated:
        session.ask(fact)
    for fact in reversed(stated):
        session.ask(UNDONE[fact])
    assert session.frame == CAMERA
    assert session.ask(OPEN).text == first.text


@given(motions, st.sampled_from(["clockwise", "counterclockwise"]))
@drawn
def test_a_turned_image_is_turned_back_before_a_direction_is_told(feelings, felt, sense):
    said = f"The image is rotated by 90 degrees {sense}. {OPEN}"
    back = turn_by_quarter(felt)
    if sense == "counterclockwise" and felt not in ROTATIONS:
        back = reverse(back)
    assert feelings.ask(felt, said).direction == back


@given(motions, facts, st.lists(st.sampled_from(DOUBTS), min_size=1, max_size=4))
@drawn
def test_doubts_never_turn_an_answer_round(feelings, felt, stated, doubts):
    session = feelings.session(felt)
    first = session.ask(" ".join((*stated, OPEN)))
    for doubt in doubts:
        again = session.ask(doubt)
        assert again == replace(first, text=again.text)
        assert first.text in again.text


@given(motions, st.sampled_from(["head", "shank"]), st.sampled_from(["right", "left"]))
@drawn
def test_thread_and_side_and_turn_each_invert_tightening(feelings, felt, side, thread):
    frame = FrameSpec(contact_side=side, thread=thread)
    answer = feelings.ask(felt, "Is it tightening or loosening?", frame)
    if felt not in ROTATIONS:
        assert answer.decided == "neither"
        return
    inversions = (side == "shank") + (thread == "left") + (felt is Motion.COUNTERCLOCKWISE)
    assert answer.decided == ("loosens" if inversions % 2 else "tightens")
    other = replace(frame, thread="left" if thread == "right" else "right")
    assert feelings.ask(felt, "Is it tightening or loosening?", other).decided != answer.decided


KINDS = (
    OPEN,
    "Is it turning clockwise?",
    "Isn't it sliding left?",
    "Is it turning or sliding?",
    "A) clockwise B) left C) up",
    "And mirrored?",
    "And played backwards?",
    "What undoes it?",
    "Seen from the object's side?",
    "Which way does the sensor move?",
    "How sure are you?",
    "How sure are you that it turns clockwise?",
    "Which way does the top go?",
    "Does the top go right?",
)


@given(states, st.sampled_from(KINDS), frames)
@drawn
def test_yes_and_no_sum_to_one_and_no_answer_is_surer_than_what_it_says(feels, felt, asked, frame):
    answer = feels.ask(felt, asked, frame)
    assert all(0.0 <= share <= 1.0 + 1e-9 for share in answer.options.values())
    if "yes" in answer.options or "it is" in answer.options:
        assert sum(answer.options.values()) == pytest.approx(1.0)
    if not answer.abstained and answer.decided in answer.options:
        assert answer.confidence <= answer.options[answer.decided] + 1e-9


@given(states, frames, st.sampled_from(list(CLAIMED)))
@drawn
def test_a_claim_its_denial_and_the_open_answer_never_contradict(feels, felt, frame, claim):
    opened = feels.ask(felt, "Which way is it moving?", frame)
    claimed = feels.ask(felt, f"Is it {CLAIMED[claim]}?", frame)
    denied = feels.ask(felt, f"Is it not {CLAIMED[claim]}?", frame)
    goes = {frame.tell(way) for way in felt}
    assert claimed.decided == _word(claim in goes)
    assert denied.decided == ("it is" if claim in goes else "it is not")
    assert (claim.value in _told(opened.text)) == (claim in goes)
    assert opened.direction == frame.tell(felt[0])
    kind = "turning" if claim in ROTATIONS else "sliding"
    asked = feels.ask(felt, f"Which way is it {kind}?", frame)
    is_asked = [way for way in goes if COMPONENT_OF[way] is COMPONENT_OF[claim]]
    assert asked.direction == (is_asked[0] if is_asked else opened.direction)


@given(states, frames)
@drawn
def test_a_belief_mirrored_or_reversed_mirrors_or_reverses_every_answer(feels, felt, frame):
    for question in ("Which way does it move?", "Which way is it turning?", "Is it turning left?"):
        for change, supposed in ((mirror, "mirrored"), (reverse, "played backwards")):
            other = tuple(map(change, felt))
            told, seen = feels.ask(felt, question, frame), feels.ask(other, question, frame)
            if not question.startswith("Is"):
                supposes = feels.ask(felt, f"If it were {supposed}, {question.lower()}", frame)
                assert supposes.direction == seen.direction
            assert told.confidence == pytest.approx(seen.confidence)


@given(
    motions,
    st.sampled_from([kind for kind in KINDS if "the top" not in kind]),
    st.sampled_from(["{}", "Please: {}", "Hello! {}", "{} Thanks!", "  {}  "]),
    st.sampled_from([str, str.lower]),
)
@drawn
def test_courtesies_case_and_spaces_change_no_answer(feelings, felt, question, around, cased):
    plain, said = (feelings.ask(felt, one) for one in (question, cased(around.format(question))))
    assert (said.decided, said.direction, said.text) == (plain.decided, plain.direction, plain.text)


@given(st.sampled_from(list(Motion)), frames)
@drawn
def test_a_kind_is_the_same_from_every_side(feelings, felt, frame):
    for question in ("stick or slip?", "Any rotation?", "Any translation?"):
        seen, told = (feelings.ask(felt, question, one) for one in (CAMERA, frame))
        assert (seen.decided, seen.confidence) == (told.decided, told.confidence)
        assert set(seen.options) == set(told.options)


@given(
    st.sampled_from(list(Motion)),
    frames,
    st.sampled_from([("rotation", "turn"), ("slip", "slide")]),
)
@drawn
def test_a_denied_kind_swaps_yes_and_no(feelings, felt, frame, named):
    noun, verb = named
    claimed = feelings.ask(felt, f"{noun}: yes/no?", frame)
    denied = feelings.ask(felt, f"Is it true that it does not {verb}?", frame)
    assert {claimed.decided, denied.decided} == {"yes", "no"}
    assert denied.options["yes"] == pytest.approx(claimed.options["no"])


def _told(text):
    """The ways that an open answer tells, without the frame's words."""
    text = text.partition(" in the camera")[0].partition(" seen from")[0]
    return {word.strip(",.") for word in text.lower().split()}


def _word(is_so):
    return "yes" if is_so else "no"
