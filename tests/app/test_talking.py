"""What the page shows when a question is asked: answer, evidence, facts, code, errors."""

import sys
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from app import conversation as facts
from app.__main__ import serve
from app.clips import Source, perceive
from app.conversation import Talking, code_of, fields_of, suggested
from app.sources import FIRST, examples
from app.toolkit import COMPLAINT, filling
from geotlm_lm import FrameSpec, GeoTLMError
from geotlm_lm.core.errors import MissingDependency
from tests.app.fakes import FakeAnswerer, load_clip
from tests.app.test_stage import clip_of, tracked  # noqa: F401


def saved(folder, name="clip.npy", top=230):
    frames = np.random.default_rng(0).integers(0, top, (20, 64, 80, 3)).astype(np.uint8)
    np.save(folder / name, frames)
    return str(folder / name)


class Talk:
    """A conversation about one recording."""

    def __init__(self, path):
        self.answerer = FakeAnswerer()
        self.shown = replace(load_clip(self.answerer, path), source=Source(path, "clip.npy"))
        self.talking, self.last = Talking(self.answerer), None

    def ask(self, question, checked=(), mm_per_px=None):
        given = (question, self.shown, list(checked), mm_per_px)
        pending, values = self.talking.ask(*given)
        assert pending["chat"]["pending"] == question
        assert values["chat"]["pending"] is None
        self.last = values["chat"]["exchanges"][-1]
        return pending | values

    @property
    def sentence(self):
        return self.last["answer"]


@pytest.fixture
def talk(tmp_path):
    return Talk(saved(tmp_path))


def test_an_answer_stands_beside_its_evidence(talk):
    values = talk.ask("Which way?")
    assert talk.sentence.startswith("It slides right, ")
    assert talk.sentence.endswith(", in the camera image.")
    assert talk.last["sure"] == 95
    evidence = values["evidence"]
    assert evidence["probabilities"][0] == ("right", 0.97)
    assert (values["question"], facts.way_seen(talk.shown.session)) == ("", "right")
    assert evidence["notes"] == [
        "Pixels are those of the 80x64 frames; tell the mm per pixel to have mm."
    ]
    readers = [row[:2] for row in evidence["verdicts"]]
    assert readers[:2] == [["answer", "right"], ["linear probe", "right"]]
    assert evidence["verdicts"][1][2] == "90 % (not calibrated)"
    # The fake perceives one unit to the right, in the left half only.
    assert evidence["regions"][3:5] == [["left", 1.0, 0.0, 1.0], ["right", 0.0, 0.0, 0.0]]
    assert evidence["timing"].startswith("encode 1.0 ms · read ")
    assert evidence["band"].startswith("Contact share 0.500; below 0.005 no direction is claimed")
    assert evidence["band"].endswith("this answer is told.")


def test_facts_hold_for_the_turns_that_follow_and_show_in_the_page(talk):
    talk.ask("Which way?", [facts.MIRRORED])
    assert facts.way_seen(talk.shown.session) == "right"  # in the camera image
    assert talk.sentence.startswith("It slides left, ")
    checked = talk.ask("I look from the object's side.", [facts.MIRRORED])["frame"]
    assert checked == [facts.MIRRORED, facts.OTHER_SIDE]
    assert "seen from the object" in talk.ask("Which way?", checked)["framed"]
    assert talk.sentence.startswith("It slides right, ")


def test_every_frame_that_can_be_checked_is_shown_as_it_was_checked():
    sides = ("object", "sensor")
    for turn, *seen in product((0, 90, 180, 270), (False, True), sides, sides):
        frame = FrameSpec(*seen, **FrameSpec.fields_of_turn(turn))
        assert FrameSpec(**fields_of(facts.facts_of(frame))) == frame


def test_turns_that_are_checked_add_up_and_of_both_quarters_the_last_holds():
    both = fields_of([facts.UPSIDE_DOWN, facts.CLOCKWISE])
    assert FrameSpec(**both) == FrameSpec(image_quarter_turn="counterclockwise")
    assert FrameSpec(**fields_of([facts.CLOCKWISE, facts.COUNTERCLOCKWISE])) == FrameSpec()
    before = [facts.CLOCKWISE, facts.MIRRORED]
    held = facts.update_facts(before, facts.COUNTERCLOCKWISE, True)
    assert held == [facts.MIRRORED, facts.COUNTERCLOCKWISE]
    assert facts.update_facts(held, facts.MIRRORED, False) == held[1:]
    assert facts.update_facts(before, facts.UPSIDE_DOWN, True) == [*before, facts.UPSIDE_DOWN]
    assert facts.in_frame([facts.OTHER_SIDE], "clockwise").endswith("is **counterclockwise**.")


def test_how_sure_an_answer_is_is_stated_once(talk):
    talk.ask("Which way?")
    first = talk.sentence
    talk.ask("Are you sure?")
    assert talk.last["sure"] is None
    assert talk.sentence == f"About 95%: i{first[1:]}"


@pytest.mark.parametrize(
    ("checked", "way", "moved"),
    [
        ([facts.MIRRORED], "left", "2.0 degrees counterclockwise, 3.0 px left, 1.0 px down"),
        ([facts.CLOCKWISE], "up", "2.0 degrees clockwise, 1.0 px right, 3.0 px up"),
        ([facts.SENSOR_MOVES], "left", "2.0 degrees counterclockwise, 3.0 px left, 1.0 px up"),
    ],
)
def test_all_verdicts_are_told_in_the_frame_of_the_answer(talk, checked, way, moved):
    flow = {"motion": "right", "rotation_deg": 2.0, "slide_x_px": 3.0, "slide_y_px": 1.0}
    talk.shown.opinions["optical_flow"] = flow
    verdicts = talk.ask("Which way?", checked)["evidence"]["verdicts"]
    assert [row[1] for row in verdicts] == [way] * 3
    assert verdicts[2][2] == moved


QUESTION = "Is it <b>5 px</b> &amp; a < b?"


def test_a_question_is_asked_again_as_it_was_typed(talk):
    asked = []
    talk.answerer.bundle.reader.lines[QUESTION] = "way all"
    talk.ask(QUESTION)
    assert talk.last["question"] == QUESTION
    talk.shown.session.take_back = SimpleNamespace(call=asked.append).call
    *_, again = talk.talking.again(talk.shown, [], None)
    assert asked == [QUESTION]
    assert again["chat"]["exchanges"][-1]["question"] == QUESTION
    assert "question" not in again  # what is being typed stays


def test_a_question_that_is_refused_comes_back_to_its_field(talk):
    asked = talk.talking.ask(" ", talk.shown, [], None)
    assert next(asked)["chat"]["pending"] == " "
    refused = next(asked)
    assert (refused["question"], refused["chat"]["pending"]) == (" ", None)
    with pytest.raises(GeoTLMError):
        next(asked)


def test_the_code_of_a_conversation_gives_its_answers(tmp_path, monkeypatch, capsys):
    talk = Talk(saved(tmp_path, "my 'clip'.npy"))
    source = Source([talk.shown.source.path], "my 'clip'.npy", span=(0, 9))
    talk.shown = replace(talk.shown, source=source)
    questions = ["Which way?", "I look from the object's side.", "Which way?"]
    answers, checked = [], [facts.MIRRORED]
    for question in questions:
        values = talk.ask(question, checked, 0.06)
        answers.append(talk.sentence)
        checked = values["frame"]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("geotlm_lm.Answerer", SimpleNamespace(load=FakeAnswerer), raising=False)
    exec(values["code"], {})
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 3
    # Told at the end in the frame that holds from its beginning, which need not be named.
    assert answers[-1].startswith(printed[-1].removesuffix("."))


def test_the_code_names_an_example_and_a_topic():
    session = SimpleNamespace(frame=FrameSpec(), history=[SimpleNamespace(question="Which way?")])
    example, bag = (
        code_of(SimpleNamespace(second=None, session=session, source=source))
        for source in (
            examples()["coin"],
            Source(["/tmp/x/run.mcap"], "run.mcap", topic="/left"),
        )
    )
    assert "read_clip('app/examples/coin_press.npz')\n" in example
    assert "read_clip('run.mcap', topic='/left')\n" in bag


def test_a_question_without_a_clip_is_refused():
    asked = Talking(FakeAnswerer()).ask("Which way?", None, [], None)
    with pytest.raises(GeoTLMError, match="^No recording is open; open one first.$"):
        next(asked)


def test_a_missing_toolkit_is_told_with_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "gradio", None)
    with pytest.raises(MissingDependency, match="gradio, which is not installed; run `pip "):
        serve()


PARTS = {"chat": "the chat", COMPLAINT: "the complaint"}


def test_a_complaint_is_emptied_once_and_filled_with_the_sentence_as_it_is():
    def works_and_fails():
        yield {"chat": 1}
        yield {"chat": 2}  # another error may have been shown meanwhile
        raise GeoTLMError("<b>.npy is empty; record it again.")

    assert list(filling(PARTS, works_and_fails)()) == [
        {"the complaint": "", "the chat": 1},
        {"the chat": 2},
        {"the complaint": "&lt;b&gt;.npy is empty; record it again."},
    ]
    assert list(filling(PARTS, lambda: iter(()))()) == [{"the complaint": ""}]


def test_a_defect_is_not_taken_for_an_error_of_the_user():
    with pytest.raises(ZeroDivisionError):
        list(filling(PARTS, lambda: iter([1 / 0]))())


def test_questions_on_offer_fit_what_is_open_and_the_last_answer(tracked):  # noqa: F811
    assert suggested(None) == []
    kinds = {event.kind.value for event in tracked.encoded.track.events}
    assert suggested(tracked)[0] == facts.STORY
    assert ("How long did it touch?" in suggested(tracked)) is ("touch" in kinds)
    assert ("How far did it slide?" in suggested(tracked)) is ("slide" in kinds)
    shown = perceive(FakeAnswerer(), clip_of(4))
    assert suggested(shown) == list(facts.OF_A_CLIP)
    shown.session.answerer.bundle.reader.lines["How far did it go?"] = "extent"
    shown.session.ask("How far did it go?")
    shown.session.frame = FrameSpec(mm_per_px=0.06)
    offered = suggested(shown)
    assert offered[:2] == list(facts.OF_AN_ANSWER["way"])
    assert "How far did it go?" not in offered
    assert offered[2] == facts.IN_MM


def test_every_question_on_offer_is_understood(answerer):
    session = answerer.session(load_clip(answerer, examples()[FIRST].path).encoded)
    session.ask("When did it touch?")
    own = (*facts.OF_A_CLIP, *facts.WATCHED, *sum(facts.OF_EVENTS.values(), ()))
    about_last = sum(facts.OF_AN_ANSWER.values(), ())
    offered = (*about_last, *own, facts.TURNED_BACK, facts.IN_MM)
    for question in offered:
        reply = session.ask(question)
        asked_back = ("I am not sure what you ask", "Do you mean", "Taken as")
        assert not reply.text.startswith(asked_back), question
