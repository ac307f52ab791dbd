"""The page in a real browser: what was said of one recording never stands beside another."""

import time

import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from tests.app.browser import NAME, NOTHING_SHOWN, SHOWN  # noqa: E402
from tests.app.test_browser import CHECKED, TEXT  # noqa: E402


def shown(name):
    return f"{SHOWN} && {NAME}.innerText == {name!r}"


NONE_OPEN = f"{TEXT}.includes('No recording is open; upload a clip first.')"


def test_a_recording_that_fails_closes_the_one_before(browser, recordings, tmp_path):
    (tmp_path / "broken.npy").write_bytes(b"no recording")
    browser.upload("Recording", recordings["dark"])
    browser.wait_for(shown("dark.npy"))
    browser.fill("Question", "Which way?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('slides left, ')")
    browser.upload("Recording", tmp_path / "broken.npy")
    browser.wait_for(NOTHING_SHOWN)
    browser.wait_for(f"!{TEXT}.includes('slides left, ')")
    browser.fill("Question", "Which way?")
    browser.click("Ask", "button.primary")
    browser.wait_for(NONE_OPEN)
    browser.upload("Recording", recordings["bright"])  # beside the one that failed
    browser.wait_for(shown("bright.npy"))
    assert "tmp" not in browser.run(TEXT)


def test_a_recording_that_is_taken_away_is_closed(browser, recordings):
    browser.upload("Recording", recordings["dark"])
    browser.wait_for(shown("dark.npy"))
    browser.run("document.querySelector('button[aria-label=\"Clear\"]').click()")
    browser.wait_for(NOTHING_SHOWN)
    browser.fill("Question", "Which way?")
    browser.click("Ask", "button.primary")
    browser.wait_for(NONE_OPEN)


def test_of_two_recordings_the_newest_is_opened_alone(browser, recordings):
    browser.upload("Recording", recordings["dark"])
    browser.wait_for(shown("dark.npy"))
    browser.upload("Recording", recordings["bright"])
    browser.wait_for(f"{TEXT}.includes('bright') && !{TEXT}.includes('dark')")
    browser.fill("Question", "Which way?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('slides right, ')")


def test_what_is_shown_is_read_again_and_not_what_was_uploaded_before(browser, recordings):
    browser.upload("Recording", recordings["dark"])
    browser.wait_for(shown("dark.npy"))
    browser.open_example("cable")
    browser.wait_for(f"!{TEXT}.includes('dark')")
    browser.click("Frames and notes")
    time.sleep(1)
    browser.fill("First frame", "0")
    browser.fill("Last frame", "1.5")
    time.sleep(1)  # until the page has taken the fields in
    browser.click("Read again with these")
    browser.wait_for(f"{TEXT}.includes('The span was 0 to 1.5, expected two whole numbers')")
    browser.wait_for(NOTHING_SHOWN)
    browser.fill("Last frame", "3")
    time.sleep(1)
    browser.click("Read again with these")
    browser.wait_for(f"{TEXT}.includes('Frames 0, 1, 2, 3 are shown.')")
    browser.upload("Recording", recordings["bright"])
    browser.wait_for(f"{TEXT}.includes('bright')")
    browser.wait_for(f"{field('First frame')} == '' && {field('Last frame')} == ''")


def field(label):
    return (
        f"[...document.querySelectorAll('label')].find(e => e.innerText.startsWith({label!r}))"
        ".querySelector('input, textarea').value"
    )


def test_an_image_is_turned_one_way_or_the_other(browser):
    browser.click("Frame of reference", "button")
    for way in ("90° counterclockwise", "90° clockwise", "90° counterclockwise"):
        box = f"image is turned {way}"
        browser.run(f"document.querySelector('input[name=\"{box}\"]').click()")
        browser.wait_for(f"{CHECKED}.join() == {box!r}")
        time.sleep(1)


def test_a_comparison_is_emptied_with_its_recordings(browser, recordings, tmp_path):
    (tmp_path / "broken.npy").write_bytes(b"no recording")
    browser.click("Compare", "button[role=tab]")
    for label, name in (("First recording", "bright"), ("Second recording", "dark")):
        browser.upload(label, recordings[name])
        browser.wait_for(f"{TEXT}.includes('{name}')")
    browser.click("Compare", "button.primary")
    browser.wait_for(f"{TEXT}.includes('slides left, ') && {TEXT}.includes('No: the first')")
    clear = "[...document.querySelectorAll('button[aria-label=\"Clear\"]')]"
    browser.run(f"{clear}.filter(e => e.offsetParent).at(-1).click()")
    browser.wait_for(f"!{TEXT}.includes('slides left, ') && !{TEXT}.includes('No: the first')")
    assert "slides right, " in browser.run(TEXT)
    browser.upload("Second recording", tmp_path / "broken.npy")
    browser.wait_for(f"{TEXT}.includes('broken')")
    browser.click("Compare", "button.primary")
    browser.wait_for(f"{TEXT}.includes('broken.npy: is cut off or is no numpy file')")
    browser.wait_for(f"!{TEXT}.includes('slides right, ')")
