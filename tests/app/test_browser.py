"""The page in a real browser: every tab is used as a person does, mistakes are made."""

import time
from contextlib import ExitStack

import numpy as np
import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import ui  # noqa: E402
from geotlm_lm import Session  # noqa: E402
from geotlm_lm.answering import CAMERA  # noqa: E402
from tests.app.browser import NAME, NOTHING_SHOWN, SHOWN, STAGE  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402
from tests.track.test_idle_tracker import gel, touched  # noqa: E402

TEXT = "document.body.innerText"


@pytest.mark.parametrize("browser", [(1400, 1100), (390, 844)], indirect=True)
def test_an_example_is_one_click_and_a_question_one_more(browser):
    browser.open_example("bead")
    browser.click("Which way is it moving?", ".chips button")
    browser.wait_for(f"{TEXT}.includes('% sure)')")
    browser.click("Evidence", "button")
    browser.wait_for(f"{TEXT}.includes('optical flow')")
    wide = browser.run("document.documentElement.scrollWidth <= window.innerWidth + 1")
    assert wide, "the page is wider than the window"
    browser.open_example("cable")
    browser.wait_for(f"!{TEXT}.includes('% sure)') && !{TEXT}.includes('no direction is claimed')")


def test_a_question_without_a_clip_is_one_sentence_in_the_page(browser, tmp_path):
    (tmp_path / "broken.npy").write_bytes(b"no recording")
    browser.upload("Recording", tmp_path / "broken.npy")
    browser.wait_for(NOTHING_SHOWN)
    browser.fill("Question", "Which way?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('No recording is open; upload a clip first.')")
    assert "Traceback" not in browser.run(TEXT)


CHECKED = "[...document.querySelectorAll('input[type=checkbox]:checked')].map(box => box.name)"


def test_a_fact_told_in_the_chat_is_checked_in_the_page_and_holds_from_then_on(browser):
    browser.click("Frame of reference", "button")
    browser.fill("Question", "I look from the object's side.")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{CHECKED}.includes('seen from the object')")
    browser.fill("Question", "Which way?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('In this frame (camera image, seen from the object')")
    browser.wait_for(f"{TEXT}.includes('seen from the object\\'s side.')")


def test_a_conversation_that_is_cleared_is_forgotten(browser):
    browser.click("Evidence", "button")
    browser.fill("Question", "Which way?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('% sure)') && {TEXT}.includes('Pixels are those of the')")
    browser.run("document.querySelector('button[aria-label=\"Clear\"]').click()")
    browser.wait_for(f"!{TEXT}.includes('% sure)') && !{TEXT}.includes('Pixels are those of the')")
    browser.wait_for(f"!{TEXT}.includes('optical flow')")
    browser.fill("Question", "And mirrored?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('Ask how the touched object moves')")


def test_a_recording_is_uploaded_and_asked_about_by_keyboard_alone(browser, recordings):
    browser.upload("Recording", recordings["dark"])
    browser.wait_for(f"{SHOWN} && {NAME}.innerText == 'dark.npy'")
    browser.fill("Question", "Which way does it go?")
    browser.run(
        "[...document.querySelectorAll('label')].find(e => e.offsetParent && "
        "e.innerText.trim().startsWith('Question')).querySelector('textarea, input').focus()"
    )
    browser.press("Enter", 13, "\r")
    browser.wait_for(f"{TEXT}.includes('It slides left, ')")


class Dictating(FakeAnswerer):
    """Says a word every second, and more of them than anybody waits for."""

    def session(self, encoded, frame=CAMERA):
        return DictatingSession(self, encoded, frame)


class DictatingSession(Session):
    def stream(self, question):
        for number in range(60):
            yield f"word{number} "
            time.sleep(1)
        yield self.ask(question)


@pytest.fixture
def asking(new_browser):
    """Open a page that answers with a given stand-in, an example shown and a question asked."""
    with ExitStack() as opened:

        def ask(answerer):
            page = ui.build(answerer)
            opened.callback(page.close)
            browser = new_browser()
            browser.open(ui.launch(page))
            browser.fill("Question", "Which way?")
            browser.click("Ask", "button.primary")
            return browser

        yield ask


def test_the_last_question_is_asked_again_in_its_old_place(asking):
    answerer = FakeAnswerer()
    browser = asking(answerer)
    browser.wait_for(f"{TEXT}.includes('It slides ')")
    answerer.bundle.reader.lines["Which way?"] = "kind"
    browser.click("Retry")
    browser.wait_for(f"{TEXT}.includes('A slide')")
    browser.wait_for(f"!{TEXT}.includes('It slides ')")
    assert browser.run(f"{TEXT}.split('Which way?').length") == 2


PIXEL = (
    "[...document.querySelectorAll('label')].find(e => e.innerText.startsWith('Millimetres'))"
    ".querySelector('input').value"
)


def ask_until(browser, sign, question, mm_per_px=None):
    """Ask until an expression is true: a click while an answer still comes is passed over."""
    until = time.monotonic() + 180
    while not browser.run(sign):
        assert time.monotonic() < until, sign
        if mm_per_px is not None:
            browser.fill("Millimetres per pixel", mm_per_px)
        browser.fill("Question", question)
        browser.click("Ask", "button.primary")
        time.sleep(2)


def test_the_size_of_a_pixel_is_given_said_and_shown(asking, recordings):
    browser = asking(FakeAnswerer())
    browser.click("Frame of reference", "button")
    browser.wait_for(f"/It slides .* px, /.test({TEXT})")
    ask_until(browser, f"/It slides .* mm[,.]/.test({TEXT})", "Which way?", "0.06")
    ask_until(browser, f"{PIXEL} == '0.05'", "0.05 mm per pixel. Which way?")
    refused = f"{TEXT}.includes('A pixel of 60 mm was given, expected')"
    ask_until(browser, refused, "Which way?", "60")
    browser.upload("Recording", recordings["bright"])  # its frames are of another size
    browser.wait_for(f"{PIXEL} == '0'")


def test_an_answer_is_stopped_half_way(asking):
    browser = asking(Dictating())
    browser.wait_for(f"{TEXT}.includes('word1')")
    browser.click("Stop")
    time.sleep(2)
    conversation = "document.querySelector('.chat').innerText"
    said = browser.run(conversation)
    time.sleep(4)
    assert browser.run(conversation) == said


def test_a_touch_is_simulated_and_asked_about(browser):
    browser.click("Simulate", "button[role=tab]")
    browser.click("Simulate and ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('(wrong: it was clockwise and right)')")
    browser.wait_for(SHOWN)
    for layer in ("Arrows", "True motion", "Depth"):
        browser.click(layer, ".stage-layers button")
    browser.fill("Seed", "99999999999")  # beyond the greatest
    browser.click("Simulate and ask", "button.primary")
    browser.wait_for(f"{NOTHING_SHOWN} && {TEXT}.includes('seed is')", seconds=30)
    assert "(wrong: it was clockwise and right)" not in browser.run(TEXT)


TOLD = f"({STAGE}.querySelector('.stage-time').getAttribute('aria-label') || '')"
CHAT = "[...document.querySelectorAll('.chat')].find(one => one.offsetParent)"


def test_a_recording_is_watched(browser, tmp_path):
    browser.click("Live", "button[role=tab]")
    browser.click("Watch", "button.primary")
    browser.wait_for(f"{TEXT}.includes('No recording was given; upload one first.')")
    plain = gel()
    frames = [next(plain) for _ in range(12)] + [touched(next(plain)) for _ in range(28)]
    np.savez(tmp_path / "watched.npz", frames=np.stack(frames), fps=25.0)
    browser.upload("Recording", tmp_path / "watched.npz")
    browser.wait_for(f"{TEXT}.includes('watched')")
    browser.click("Watch", "button.primary")
    browser.wait_for(f"{TEXT}.includes('idle gel learnt · 40 frames')")
    browser.wait_for(f"{TOLD}.includes('stick')")
    browser.click("When did it stop?", ".chips button")
    browser.wait_for(f"{CHAT}.innerText.includes('neither turns nor slides')")
    browser.click("Stop and clear")
    browser.wait_for(f"{NOTHING_SHOWN} && !{TEXT}.includes('idle gel learnt')")
    browser.wait_for(f"!{CHAT}.innerText.includes('neither turns nor slides')")


def test_a_recording_that_is_watched_no_longer_leaves_the_stage_empty(browser, long_recording):
    browser.click("Live", "button[role=tab]")
    browser.upload("Recording", long_recording)
    browser.wait_for(f"{TEXT}.includes('long')")
    browser.click("Watch", "button.primary")
    browser.wait_for(f"{TOLD}.includes('release')")
    browser.click("Stop and clear")
    browser.wait_for(NOTHING_SHOWN)
    time.sleep(3)
    assert browser.run(NOTHING_SHOWN)
    assert "idle gel learnt" not in browser.run(TEXT)
