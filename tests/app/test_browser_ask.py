"""The page in a real browser: every tab is used as a person does, mistakes are made."""

import threading
import time

import pytest

from geotlm_lm import Session
from tests.app.browser import CHAT, NAME, NOTHING_SHOWN, SHOWN, STAGE, TEXT

pytestmark = pytest.mark.slow

TOLD = f"({STAGE}.querySelector('.stage-time').getAttribute('aria-label') || '')"
CHECKED = "[...document.querySelectorAll('input[type=checkbox]:checked')].map(box => box.name)"
COMPARE = f"Boolean({STAGE}.querySelector('[data-event=expand]').offsetParent)"
NONE_OPEN = f"{TEXT}.includes('No recording is open; open one first.')"


def value_of(label):
    return (
        f"[...document.querySelectorAll('label')].find(e => e.innerText.startsWith({label!r}))"
        ".querySelector('input, textarea').value"
    )


def test_an_example_is_one_click_and_a_question_one_more(browser):
    browser.open_example("bead")
    browser.click("Which way is it moving?", ".chips button")
    browser.wait_for(f"{CHAT}.innerText.includes('% sure')")
    browser.click("Details", "button")
    browser.wait_for(f"{TEXT}.includes('optical flow')")
    browser.open_example("cable")
    browser.wait_for(
        f"!{CHAT}.innerText.includes('% sure') && !{TEXT}.includes('no direction is claimed')"
    )


def test_a_recording_that_fails_leaves_the_one_before_open(browser, recordings, tmp_path):
    (tmp_path / "broken.npy").write_bytes(b"no recording")
    browser.open_recording(recordings["dark"])
    browser.ask("Which way?")
    browser.wait_for(f"{TEXT}.includes('slides left, ')")
    browser.upload("Recording", tmp_path / "broken.npy")
    browser.wait_for("document.querySelector('.complaint').innerText.includes('broken.npy')")
    box = "document.querySelector('.drop').innerText"
    browser.wait_for(f"{SHOWN} && {box}.includes('dark') && !{box}.includes('broken')")
    assert browser.run(f"{NAME}.innerText") == "dark.npy"
    browser.ask("Which way?")
    browser.wait_for(f"{CHAT}.innerText.split('slides left, ').length == 3")
    browser.open_recording(recordings["bright"])
    browser.wait_for(f"{TEXT}.includes('bright') && !{TEXT}.includes('dark')")
    assert not {word for word in ("tmp", "Traceback") if word in browser.run(TEXT)}
    browser.run("document.querySelector('button[aria-label=\"Clear\"]').click()")
    browser.wait_for(NOTHING_SHOWN)
    browser.fill("Question", "Which way?")
    browser.click_until("Ask", NONE_OPEN, "button.primary")


def test_a_fact_stated_in_the_chat_is_checked_in_the_page_and_holds_from_then_on(browser):
    browser.open_example("bead")
    browser.click("Details", "button")
    browser.ask("I look from the object's side.")
    browser.wait_for(f"{CHECKED}.includes('seen from the object')")
    browser.ask("Which way?")
    browser.wait_for(f"{TEXT}.includes('In this frame (camera image, seen from the object')")
    browser.wait_for(f"{TEXT}.includes('seen from the object\\'s side.')")


def test_an_image_is_turned_one_way_or_the_other(browser):
    browser.click("Details", "button")
    for way, back in (("counterclockwise", "clockwise"), ("clockwise", "counterclockwise")) * 2:
        box = f"image is turned 90° {way}"
        browser.run(f"document.querySelector('input[name=\"{box}\"]').click()")
        browser.wait_for(f"{CHECKED}.join() == {box!r}")
        browser.wait_for(f"{TEXT}.includes('turned back by 90 degrees {back}')")


def test_a_conversation_that_is_cleared_is_forgotten(browser):
    browser.open_example("bead")
    browser.click("Details", "button")
    browser.ask("Which way?")
    browser.wait_for(
        f"{CHAT}.innerText.includes('% sure') && {TEXT}.includes('Pixels are those of the')"
    )
    browser.run("document.querySelector('button[data-part=clear]').click()")
    browser.wait_for(
        f"!{CHAT}.innerText.includes('% sure') && !{TEXT}.includes('Pixels are those of the')"
    )
    browser.wait_for(f"!{TEXT}.includes('optical flow')")
    browser.wait_for(f"{TEXT}.includes('Ask how the touched object moves')")


def test_a_recording_is_uploaded_and_asked_about_by_keyboard_alone(browser, recordings):
    browser.open_recording(recordings["dark"])
    browser.fill("Question", "Which way does it go?")
    browser.run(
        "[...document.querySelectorAll('label')].find(e => e.offsetParent && "
        "e.innerText.trim().startsWith('Question')).querySelector('textarea, input').focus()"
    )
    browser.press("Enter", 13, "\r")
    browser.wait_for(f"{TEXT}.includes('It slides left, ')")


def test_the_last_question_is_asked_again_in_its_old_place(browser, fake, monkeypatch):
    browser.open_example("bead")
    browser.ask("Which way?")
    browser.wait_for(f"{TEXT}.includes('It slides ')")
    monkeypatch.setitem(fake.bundle.reader.lines, "Which way?", "kind")
    browser.click_until("Retry", f"{TEXT}.includes('A slide')")
    browser.wait_for(f"!{TEXT}.includes('It slides ')")
    assert browser.run(f"{TEXT}.split('Which way?').length") == 2


def test_the_size_of_a_pixel_is_given_said_and_shown(browser, recordings):
    browser.open_example("bead")
    size = value_of("Millimetres")
    browser.click("Details", "button")
    browser.ask("Which way?")
    browser.wait_for(f"/It slides .* px, /.test({TEXT})")
    browser.fill("Millimetres per pixel", "0.06")
    browser.ask("Which way?")
    browser.wait_for(f"/It slides .* mm[,.]/.test({TEXT})")
    browser.ask("0.05 mm per pixel. Which way?")
    browser.wait_for(f"{size} == '0.05'")
    browser.upload("Recording", recordings["bright"])  # its frames are of another size
    browser.wait_for(f"{size} == '0'")


def test_what_is_shown_is_read_again_and_not_what_was_uploaded_before(browser, recordings):
    browser.open_recording(recordings["dark"])
    browser.open_example("cable")
    browser.wait_for(f"!{TEXT}.includes('dark')")
    browser.click("Details", "button")
    refused = f"{TEXT}.includes('The span was 0 to 1.5, expected two whole numbers')"
    span = {"First frame": "0", "Last frame": "1.5"}
    browser.click_until("Read again with these", f"{refused} && {SHOWN}", fields=span)
    read = f"{TEXT}.includes('Frames 0, 1, 2, 3 are shown.')"
    browser.click_until("Read again with these", read, fields=span | {"Last frame": "3"})
    browser.open_recording(recordings["bright"])
    browser.wait_for(f"{value_of('First frame')} == '' && {value_of('Last frame')} == ''")


def test_a_touch_is_simulated_and_asked_about(browser):
    browser.click("Simulate", "button[role=tab]")
    browser.wait_for(f"{TEXT}.includes('it also turned clockwise 15 degrees')")
    browser.wait_for(SHOWN)
    for layer in ("Motion", "True motion", "Depth"):
        browser.click(layer, ".stage-layers button")
    slider = "[...document.querySelectorAll('input[type=range]')].find(e => e.max == '60')"
    moved = "dispatchEvent(new Event('input', {bubbles: true}))"
    browser.run(f"{slider}.value = -40; {slider}.{moved}")
    browser.wait_for(f"{TEXT}.includes('true 40° counterclockwise')")
    browser.fill("Seed", "99999999999")  # beyond the greatest
    # The touch before stays on the stage.
    browser.wait_for(f"{SHOWN} && {TEXT}.includes('seed is')", seconds=30)
    browser.wait_for(f"{TEXT}.includes('true 40° counterclockwise')")


def test_a_recording_is_watched(browser, touch_path):
    browser.click("Live", "button[role=tab]")
    browser.fill("Mark the moment", "it has turned 300 degrees")
    browser.click("Mark")
    browser.wait_for(f"{TEXT}.includes('Will wait for this: it turns by more than 300 degrees')")
    shown = "[...document.querySelectorAll('button')].filter(one => one.offsetParent)"
    again = f"{shown}.some(one => one.innerText == 'Watch again')"
    assert not browser.run(again)  # there is no file
    browser.upload("Recording", touch_path)
    browser.wait_for(f"{TEXT}.includes('idle gel learnt · 40 frames')")
    browser.wait_for(f"{TEXT}.includes('Did not hold: it turns by more than 300 degrees')")
    browser.wait_for(f"{TOLD}.includes('rest')")
    answered = f"{CHAT}.innerText.includes('does not happen in this recording')"
    browser.click("When did it stop?", ".chips button")
    browser.wait_for(answered)
    browser.wait_for(again)
    browser.click("Watch again")
    browser.wait_for(f"!{answered}")
    browser.wait_for(f"{TEXT}.includes('Did not hold: it turns by more than 300 degrees')")
    browser.click("When did it stop?", ".chips button")
    browser.wait_for(answered)
    browser.click("Stop and clear")
    browser.wait_for(f"{NOTHING_SHOWN} && !{TEXT}.includes('idle gel learnt')")
    browser.wait_for(f"{value_of('Mark the moment')} == '' && !{TEXT}.includes('Did not hold')")
    browser.wait_for(f"!{CHAT}.innerText.includes('does not happen in this recording')")


def test_two_recordings_are_compared_and_one_is_closed_again(browser):
    second = "document.querySelector('.stage-second .stage')"
    browser.open_example("bead")
    browser.click("Compare", ".stage-actions button")
    browser.wait_for(f"{second}.offsetParent && {TEXT}.includes('Choose a second recording')")
    browser.click("cable", "button.example")
    browser.wait_for(f"{second}.dataset.shown == 'all' && {second}.innerText.includes('cable')")
    assert browser.run(NAME + ".innerText") == "bead"
    browser.ask("Do they turn the same way?")
    browser.wait_for(f"{CHAT}.innerText.includes('the first ')")
    browser.run(f"{second}.querySelector('[data-event=collapse]').click()")
    browser.wait_for(f"!{second}.offsetParent && {SHOWN}")
    assert browser.run(NAME + ".innerText") == "bead"


def test_a_camera_that_is_missing_is_told_in_words(browser):
    browser.click("Live", "button[role=tab]")
    browser.click("Click to Access Webcam")
    browser.wait_for(f"{TEXT}.includes('No camera is connected')")


def test_a_question_that_is_stopped_does_not_appear_later(browser, monkeypatch):
    release, ask = threading.Event(), Session.ask
    browser.open_example("bead")

    def slow(session, question):
        release.wait(30)
        return ask(session, question)

    with monkeypatch.context() as patch:
        patch.setattr(Session, "ask", slow)
        browser.fill("Question", "How far did it go?")
        browser.click("Ask", "button.primary")
        browser.wait_for(f"{CHAT}.innerText.includes('Answering…')")
        browser.click("Stop", ".waits button")
        browser.wait_for(f"!{CHAT}.innerText.includes('How far did it go?')")
        release.set()
    browser.ask("Which way does it go?")
    browser.wait_for(f"{CHAT}.innerText.includes('It slides ')")
    assert "How far did it go?" not in browser.run(f"{CHAT}.innerText")


def test_of_a_recording_that_is_stopped_the_part_before_answers_what_waits(
    browser, fake, long_recording, monkeypatch
):
    encode = fake.encode

    def slow(clip, *, follow, **named):
        return encode(clip, follow=lambda each: time.sleep(0.05) or follow(each), **named)

    with monkeypatch.context() as patch:
        patch.setattr(fake, "encode", slow)
        browser.upload("Recording", long_recording)
        browser.wait_for(f"/tracking, [0-9]+%/.test({STAGE}.innerText)", seconds=15)
        assert not browser.run(COMPARE)
        browser.fill("Question", "Which way does it go?")
        browser.click("Ask", "button.primary")
        browser.wait_for(f"{CHAT}.innerText.includes('(waiting until the recording is read)')")
        browser.click("Stop", ".stage-bar button")
        browser.wait_for(f"{SHOWN} && /Stopped at [0-9.]+ s of 56.4 s/.test({STAGE}.innerText)")
        browser.wait_for(f"{CHAT}.innerText.includes('% sure')")
    assert "waiting" not in browser.run(f"{CHAT}.innerText")
    assert browser.run(COMPARE)
    browser.open_example("cable")
