"""The page in a real browser: an example is clicked, a question asked, a mistake made."""

import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import ui  # noqa: E402
from app.browser import EXECUTABLE, Browser  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

pytestmark = pytest.mark.skipif(
    EXECUTABLE is None, reason="needs a Chromium (Debian: apt-get install chromium)"
)

TEXT = "document.body.innerText"


@pytest.fixture(scope="module")
def address():
    page = ui.build(FakeAnswerer())
    yield ui.launch(page)
    page.close()


@pytest.fixture(params=[(1400, 1100), (390, 844)], ids=["wide", "phone"])
def browser(request, tmp_path, address):
    browser = Browser(tmp_path, request.param)
    browser.open(address)
    yield browser
    browser.close()


def test_an_example_is_one_click_and_a_question_one_more(browser):
    browser.run("document.querySelector('.thumbnail-item').click()")
    browser.wait_for("[...document.images].some(i => i.offsetParent && i.naturalWidth == 448)")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('% sure)')")
    browser.wait_for(f"{TEXT}.includes('optical flow')")
    wide = browser.run("document.documentElement.scrollWidth <= window.innerWidth + 1")
    assert wide, "the page is wider than the window"
    browser.run("document.querySelectorAll('.thumbnail-item')[1].click()")
    browser.wait_for(f"!{TEXT}.includes('% sure)') && !{TEXT}.includes('no direction is claimed')")


def test_a_question_without_a_clip_is_one_sentence_in_the_page(browser):
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('No recording is open; upload a clip first.')")
    assert "Traceback" not in browser.run(TEXT)


CHECKED = "[...document.querySelectorAll('input[type=checkbox]:checked')].map(box => box.name)"


def test_a_fact_told_in_the_chat_is_checked_in_the_page_and_holds_from_then_on(browser):
    browser.run("document.querySelector('.thumbnail-item').click()")
    browser.wait_for("[...document.images].some(i => i.offsetParent && i.naturalWidth == 448)")
    browser.fill("Question", "I look from the object's side.")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{CHECKED}.includes('seen from the object')")
    browser.wait_for(f"{TEXT}.includes('In this frame (camera image, seen from the object')")
    browser.fill("Question", "Are you sure?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('I stay with it, 97%: To the ')")
