"""The page's functions, without the page: a clip is shown, questions are answered, errors told."""

import cv2
import numpy as np
import pytest
from app.clip_loading import load_clip

from app import facts as page_facts
from app import handlers, ui
from geotlm_lm import FrameSpec, GeoTLMError, Motion
from geotlm_lm.core.errors import MissingDependency
from tests.app.fakes import FakeAnswerer


def saved(folder, name="clip.npy", top=200):
    frames = np.random.default_rng(0).integers(0, top, (20, 64, 80, 3)).astype(np.uint8)
    np.save(folder / name, frames)
    return str(folder / name)


@pytest.fixture
def path(tmp_path):
    return saved(tmp_path, top=230)


def test_a_clip_is_shown_as_its_four_frames_with_notes(path):
    shown = load_clip(FakeAnswerer(), path, 3, 9)
    assert [caption for _, caption in shown.frames] == ["frame 3", "frame 5", "frame 7", "frame 9"]
    assert "- Frames 3, 5, 7, 9 are shown." in shown.notes


def test_an_answer_is_shown_with_its_probabilities(path):
    answerer = FakeAnswerer()
    reply = handlers.ask(answerer, load_clip(answerer, path, None, None), "Which way?")
    assert reply.sentence.startswith("It slides right, ")
    assert reply.sentence.endswith(", in the camera image.  (95 % sure)")
    assert (reply.probabilities["right"], reply.probabilities["left"]) == (0.97, 0)


def test_an_answers_own_notes_are_shown_beside_it(path):
    answerer = FakeAnswerer()
    shown = load_clip(answerer, path)
    assert shown.encoded.clip.notes  # those are told beside the clip
    assert handlers.ask(answerer, shown, "Which way?").notes == (
        "- Pixels are those of the 80x64 frames; tell the mm per pixel to have mm."
    )


def test_words_come_as_they_are_generated_and_last_the_whole_reply(path):
    answerer = FakeAnswerer()
    shown = load_clip(answerer, path)
    *pieces, reply = handlers.converse(answerer, shown, "Which way?", {})
    assert pieces[:3] == ["It ", "slides ", "right, "]
    assert reply.sentence == f"{''.join(pieces)}  (95 % sure)"
    assert reply.motion is Motion.RIGHT


def test_facts_hold_for_the_turns_that_follow_and_show_in_the_page(path):
    answerer = FakeAnswerer()
    shown = load_clip(answerer, path)
    *_, checked = handlers.converse(answerer, shown, "Which way?", {"image_mirrored": True})
    assert checked.sentence.startswith("It slides left, ")
    assert checked.motion is Motion.RIGHT  # in the camera image, as before
    *_, stated = handlers.converse(answerer, shown, "I look from the object's side.", {})
    *_, both = handlers.converse(answerer, shown, "Which way?", {})
    assert both.sentence.startswith("It slides right, ")
    assert page_facts.facts_of(shown.session.frame) == [page_facts.MIRRORED, page_facts.OTHER_SIDE]


@pytest.mark.parametrize("is_mirrored", [False, True])
@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
@pytest.mark.parametrize("viewpoint", ["sensor", "object"])
@pytest.mark.parametrize("actor", ["object", "sensor"])
def test_every_frame_that_can_be_checked_is_shown_as_it_was_checked(
    is_mirrored, degrees, viewpoint, actor
):
    turned = FrameSpec.fields_of_turn(degrees)
    frame = FrameSpec(is_mirrored, viewpoint, actor, **turned)
    assert FrameSpec(**page_facts.fields_of(page_facts.facts_of(frame))) == frame


def test_turns_that_are_checked_together_add_up():
    half_and_quarter = page_facts.fields_of([page_facts.UPSIDE_DOWN, page_facts.CLOCKWISE])
    assert FrameSpec(**half_and_quarter) == FrameSpec(image_quarter_turn="counterclockwise")
    there_and_back = page_facts.fields_of([page_facts.CLOCKWISE, page_facts.COUNTERCLOCKWISE])
    assert FrameSpec(**there_and_back) == FrameSpec()


def test_how_sure_an_answer_is_is_told_from_the_conversation_and_once(path):
    answerer = FakeAnswerer()
    shown = load_clip(answerer, path)
    *_, first = handlers.converse(answerer, shown, "Which way?", {})
    *_, again = handlers.converse(answerer, shown, "Are you sure?", {})
    assert again.sentence == f"About 95%: {first.sentence.removesuffix('  (95 % sure)')}"


def test_an_answer_stands_beside_the_probe_the_flow_and_the_regions(path):
    answerer = FakeAnswerer()
    reply = handlers.ask(answerer, load_clip(answerer, path), "Which way?")
    readers = [row[0] for row in reply.verdicts]
    assert readers == ["language model", "linear probe", "optical flow"]
    assert [row[1] for row in reply.verdicts[:2]] == ["right", "right"]
    assert reply.verdicts[1][2] == "90 % (not calibrated)"
    # The fake perceives one unit to the right, in the left half only.
    assert reply.regions[3:6] == [
        ["left", 1.0, 0.0, 1.0],
        ["right", 0.0, 0.0, 0.0],
        ["left minus right", 1.0, 0.0, 0.0],
    ]
    assert reply.timing.startswith("encode 1.0 ms · read ")
    assert reply.band == (
        "Contact share 0.500; below 0.005 no direction is claimed, and no motion, verdict or "
        "choice that is less than 50% sure, nor that nothing touches a gel that has changed: "
        "this answer is **told**."
    )


@pytest.mark.parametrize(
    ("facts", "told", "moved"),
    [
        ([], "right", "+2.0 degrees, +3.0 px right, +1.0 px down"),
        ([page_facts.MIRRORED], "left", "-2.0 degrees, -3.0 px right, +1.0 px down"),
        ([page_facts.CLOCKWISE], "up", "+2.0 degrees, +1.0 px right, -3.0 px down"),
        ([page_facts.SENSOR_MOVES], "left", "-2.0 degrees, -3.0 px right, -1.0 px down"),
    ],
)
def test_all_verdicts_are_told_in_the_frame_of_the_answer(path, facts, told, moved):
    answerer = FakeAnswerer()
    shown = load_clip(answerer, path)
    flow = {"motion": "right", "rotation_deg": 2.0, "slide_x_px": 3.0, "slide_y_px": 1.0}
    shown.opinions["optical_flow"] = flow
    fields = page_facts.fields_of(facts)
    *_, reply = handlers.converse(answerer, shown, "Which way?", fields)
    assert [row[1] for row in reply.verdicts] == [told] * 3
    assert reply.verdicts[2][2] == moved


def test_of_both_quarters_the_one_checked_last_holds():
    before = [page_facts.CLOCKWISE, page_facts.MIRRORED]
    held, _, told = page_facts.update_facts(before, "right", page_facts.COUNTERCLOCKWISE, True)
    assert held == [page_facts.MIRRORED, page_facts.COUNTERCLOCKWISE]
    assert told == page_facts.frame_preview(held, "right")[1]
    assert page_facts.update_facts(held, None, page_facts.MIRRORED, False)[0] == held[1:]
    assert page_facts.update_facts(before, None, page_facts.UPSIDE_DOWN, True)[0] == [
        *before,
        page_facts.UPSIDE_DOWN,
    ]


def test_several_images_are_one_recording(tmp_path):
    paths = []
    for number in range(4):
        paths.append(str(tmp_path / f"{number}.png"))
        cv2.imwrite(paths[-1], np.full((40, 50, 3), 40 * number, np.uint8))
    shown = load_clip(FakeAnswerer(), paths)
    assert [int(frame.mean()) for frame, _ in shown.frames] == [0, 40, 80, 120]


@pytest.mark.parametrize(
    ("tops", "relation"), [((230, 230), "same"), ((230, 150), "opposite"), ((230, 10), "unknown")]
)
def test_two_clips_are_compared_by_their_directions(tmp_path, tops, relation):
    answerer = FakeAnswerer()
    shown = [load_clip(answerer, saved(tmp_path, f"{k}.npy", top)) for k, top in enumerate(tops)]
    result = handlers.compare(answerer, *shown)
    assert result["relation"] == relation
    told = {"same": "Yes: ", "opposite": "No: ", "unknown": "I cannot tell for sure, "}
    assert result["text"].startswith(told[relation])


def test_a_comparison_of_one_clip_is_told(path):
    answerer = FakeAnswerer()
    with pytest.raises(GeoTLMError, match="^A comparison needs two recordings; upload both.$"):
        handlers.compare(answerer, load_clip(answerer, path), None)


def test_a_direction_is_told_again_for_another_frame():
    told = handlers.direction_in_frame(FrameSpec(viewpoint="object"), Motion.CLOCKWISE)
    assert told.endswith("that is **counterclockwise**.")
    assert handlers.direction_in_frame(FrameSpec(), None).startswith("Frame: camera image")


def test_nothing_uploaded_is_told():
    with pytest.raises(GeoTLMError, match="^No recording was given; upload a clip first.$"):
        load_clip(FakeAnswerer(), None, None, None)


def test_a_question_without_a_clip_is_told():
    with pytest.raises(GeoTLMError, match="^No recording is open; upload a clip first.$"):
        handlers.ask(FakeAnswerer(), None, "Which way?")


def test_a_missing_toolkit_is_told_with_how_to_get_it(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "gradio", None)
    with pytest.raises(MissingDependency) as caught:
        ui.build(FakeAnswerer())
    assert str(caught.value) == (
        "The app needs gradio, which is not installed; run `pip install 'geotlm-lm[app]'`."
    )
