"""A bound without a unit counts what happens, one in a unit of time is how long it is so."""

import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.query import types as t
from geotlm_lm.query.bounds import COUNTED_ATOMS
from geotlm_lm.query.decision import Evidence
from geotlm_lm.query.execute import execute
from geotlm_lm.query.forms import decided, in_form
from geotlm_lm.query.quantities import quantities
from geotlm_lm.query.tell import tell
from geotlm_lm.query.text import read
from tests.query.strategies import edits, tracks, turning
from tests.query.test_execute import FRAME, RECORDING, answer, certain, whole

BACK_AND_FORTH = turning([40, -15, 40, 15, -40])
"""It turns back three times, twice of them by 40 degrees, and touches for six seconds of seven."""

UNTIMED = replace(RECORDING, rate_hz=None, step_s=0.04)


def asked(text, question="", track=BACK_AND_FORTH, **more):
    return answer(text, certain(turn=40), question=question, track=track, **more)


def bounded(kind, atom, relation, number, unit="", *, track, edit=None, denied=False):
    bound = t.Bound(relation, t.Quantity(number, unit))
    said = t.Proposition((t.Literal(atom, bound, denied),))
    part = replace(read("way").parts[0], ask=t.Ask(kind, said))
    part = part if edit is None else replace(part, edit=edit)
    evidence = Evidence(certain(turn=40), recording=RECORDING, track=track)
    return execute(t.Query((part,)), evidence, FRAME)[0]


@pytest.mark.parametrize(
    ("text", "question", "verdict", "time"),
    [
        ("claim reverses > #1", "more than 4 times?", False, 3),
        ("claim reverses ~ #1", "3 times?", True, 3),
        ("claim not reverses < #1", "at least 3 times?", True, 3),
        ("claim reverses in-range #1 #2", "2 to 3 times?", True, 3),
        ("claim made ~ #1", "touched 1 time?", True, 1),
        ("claim starts > #1", "started more than 4 times?", True, 5),
        ("claim touch > #1", "touched more than 1 time?", False, 1),
        ("in-first-half > claim reverses > #1", "more than 2 times?", False, 2),
        ("backwards > claim reverses ~ #1", "3 times?", True, 3),
        ("claim touch > #1", "for more than 2 s?", True, 6),
        ("claim touch > #1", "for more than 0.2 minutes?", False, 6),
        ("claim touch > #1", "for more than 140 frames?", True, 6),
        ("claim none < #1", "for less than 1500 ms?", True, 1),
        ("claim move in-range #1 #2", "between 4 and 6 s?", True, 5),
        ("claim turn ~ #1", "for about 5 s?", True, 5),
        ("claim slide > #1", "for more than 1 s?", False, 0),
        ("claim ccw > #1", "for more than 1 s?", True, 2),
        ("claim not turn > #1", "at most 4 s?", False, 5),
    ],
)
def test_a_number_alone_is_how_often_it_happens_and_one_of_time_how_long(
    text, question, verdict, time
):
    found = asked(text, question)
    assert (found.verdict, found.times) == (verdict, (pytest.approx(time, abs=0.05),))


@pytest.mark.parametrize(
    ("question", "count"),
    [
        ("by more than 20 degrees?", 2),
        ("by more than 50 degrees?", 0),
        ("by less than 20 degrees?", 1),
        ("faster than 1 rpm?", 3),
    ],
)
def test_only_reversals_that_go_so_far_are_counted(question, count):
    sign = "<" if "less" in question else ">"
    assert asked(f"how-often reverses {sign} #1", question).times == (count,)
    assert asked(f"claim reverses {sign} #1", question).verdict is (count > 0)
    assert asked("when reverses > #1 begin", "more than 20 degrees?").times == (3.0,)


@pytest.mark.parametrize(
    ("text", "question", "recording", "track", "missing"),
    [
        ("claim reverses > #1", "4 times?", RECORDING, None, "track"),
        ("claim touch > #1", "2 s?", RECORDING, None, "track"),
        ("claim touch > #1", "2 s?", UNTIMED, BACK_AND_FORTH, "rate"),
        ("claim speeds > #1", "2 times?", RECORDING, BACK_AND_FORTH, "speeds"),
        ("claim made > #1", "20 degrees?", RECORDING, BACK_AND_FORTH, "unit"),
        ("how-often touch > #1", "20 degrees?", RECORDING, BACK_AND_FORTH, "unit"),
    ],
)
def test_what_no_recording_tells_is_declined(text, question, recording, track, missing):
    query = t.filled(read(text), quantities(question))
    evidence = Evidence(certain(turn=40), recording=recording, track=track)
    assert execute(query, evidence, FRAME)[0].missing == missing


def test_frames_are_counted_without_a_rate():
    query = t.filled(read("claim touch > #1"), quantities("more than 140 frames?"))
    evidence = Evidence(certain(turn=40), recording=UNTIMED, track=BACK_AND_FORTH)
    found = execute(query, evidence, FRAME)[0]
    assert found.verdict is True
    assert tell(found, UNTIMED) == "Yes: it is touched for 150 frames; it touches at frame 0."
    assert json.loads(in_form([found], "json", UNTIMED))["frames"] == 150


@pytest.mark.parametrize(
    ("text", "question", "told"),
    [
        ("claim reverses > #1", "2 times?",
         "No: it never turns back; it turns clockwise, about 20 degrees, from 1.0 s to 2.0 s, in "
         "the camera image."),
        ("claim not lost < #1", "at least 1 time?",
         "Yes, that is so: it is let go 1 time; it lifts off at 3.0 s."),
        ("claim touch > #1 and slide", "2 s",
         "Yes: it is touched for 2.96 s; it slides left, about 43 px, from 2.0 s to 3.0 s, in the "
         "camera image."),
        ("choice A starts > #1 , B starts < #2", "more than 2 times or less than 2.5 times",
         "B: it starts to move 2 times; it turns clockwise, about 20 degrees, from 1.0 s to 2.0 s, "
         "then it slides left, about 43 px, from 2.0 s to 3.0 s, in the camera image."),
    ],
)  # fmt: skip
def test_the_count_or_the_duration_is_told(text, question, told):
    found = answer(text, certain(turn=20, right=-30), question=question, track=whole())
    assert tell(found, RECORDING) == told


def test_json_holds_verdict_and_count():
    told = json.loads(in_form([asked("claim reverses > #1", "4 times?")], "json", RECORDING))
    assert told == {"verdict": False, "count": 3, "probability": 1.0}
    both = asked("claim reverses > #1 and touch > #2", "2 times and 2 s")
    told = json.loads(in_form([both], "json", RECORDING))
    assert (told["reverses_count"], told["touch_seconds"]) == (3, 6.0)
    assert in_form([asked("claim reverses > #1", "4 times?")], "number", UNTIMED) == "3"


def test_options_are_named_with_their_bounds():
    found = asked("choice reverses > #1 , reverses < #1", "more or less than 4 times?")
    assert decided(found, RECORDING) == "reverses less than 4 times"


counts = st.integers(0, 6)


@given(st.sampled_from(sorted({*COUNTED_ATOMS} - {"speeds", "slows"})), counts, tracks, edits)
@settings(max_examples=40, deadline=None)
def test_more_less_and_as_many_exclude_each_other(atom, number, track, edit):
    verdicts, chances = {}, {}
    for relation in ("more", "less", "about"):
        found = bounded("claim", atom, relation, number, track=track, edit=edit)
        sure = bounded("how-sure", atom, relation, number, track=track, edit=edit)
        verdicts[relation], chances[relation] = found.verdict, sure.chances[0]
    often = execute(
        t.Query((replace(read(f"how-often {atom}").parts[0], edit=edit),)),
        Evidence(certain(turn=40), recording=RECORDING, track=track), FRAME,
    )[0]  # fmt: skip
    count = often.times[0]
    assert verdicts == {"more": count > number, "less": count < number, "about": count == number}
    assert sum(chances.values()) == pytest.approx(1)
    exact = bounded("claim", atom, "about", count, track=track, edit=edit)
    assert exact.probability == pytest.approx(often.probability)


bounds = st.one_of(
    st.tuples(st.sampled_from(["reverses", "made", "lost", "starts", "stops"]), st.just("")),
    st.tuples(st.sampled_from(["touch", "none", "still", "move", "turn", "slide", "cw"]),
              st.sampled_from(["s", "frame"])),
)  # fmt: skip


@given(bounds, st.sampled_from(["more", "less", "about"]), counts, tracks)
@settings(max_examples=40, deadline=None)
def test_a_bound_and_its_denial_add_to_one(said, relation, number, track):
    atom, unit = said
    so, denied = (
        bounded("how-sure", atom, relation, number, unit, track=track, denied=one)
        for one in (False, True)
    )
    assert so.chances[0] + denied.chances[0] == pytest.approx(1)
    verdicts = [
        bounded("claim", atom, relation, number, unit, track=track, denied=one).verdict
        for one in (False, True)
    ]
    assert sorted(verdicts) == [False, True]


@given(st.sampled_from(["touch", "none", "still", "move", "turn", "cw"]), st.floats(0, 9), tracks)
@settings(max_examples=40, deadline=None)
def test_a_duration_is_judged_as_it_is_told(atom, seconds, track):
    found = bounded("claim", atom, "more", seconds, "s", track=track)
    told = asked(f"how-long {atom}", track=track)
    assert found.times == told.times
    assert found.verdict is (told.times[0] > seconds)
    assert found.probability == pytest.approx(told.probability)
