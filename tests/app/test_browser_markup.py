"""The page in a real browser: what a person typed is shown as it is, and nothing is fetched."""

import threading
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from geotlm_lm import Session
from geotlm_lm.answering import CAMERA
from tests.app.browser import TEXT
from tests.app.fakes import FakeAnswerer

pytestmark = pytest.mark.slow


class Echoing(FakeAnswerer):
    """Repeats the question in its words and in a note."""

    asked = "Which way?"

    def session(self, encoded, frame=CAMERA):
        return EchoingSession(self, encoded, frame)


class EchoingSession(Session):
    def ask(self, question):
        self.answerer.bundle.reader.lines[question] = "way all"
        answer = super().ask(question)
        return replace(answer, text=f"You said {question}", notes=(f"Noted: {question}",))


@pytest.fixture
def elsewhere():
    """Another site, and the paths that it was asked for."""
    asked = []

    class Site(BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.path)
            self.send_response(404)
            self.end_headers()

        def log_message(self, *_):
            pass

    server = HTTPServer(("127.0.0.1", 0), Site)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}", asked
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def fake():
    return Echoing()


@pytest.mark.parametrize(
    "markup",
    [
        "![seen]({site}/markdown.png) **bold** www.example.org $a$",
        "<img src='{site}/html.png'><b>bold</b> <svg><image href='{site}/svg.png'/></svg>",
        "[![seen]({site}/nested.png)]({site}/link) `code` &amp; <script>document.title=1</script>",
    ],
    ids=["markdown", "html", "nested"],
)
def test_a_question_is_shown_as_it_was_typed(browser, fake, elsewhere, recordings, markup):
    site, asked = elsewhere
    fake.asked = markup.format(site=site)
    browser.open_recording(recordings["dark"])
    browser.click("Details", "button")
    browser.fill("Question", fake.asked)
    browser.click("Ask", "button.primary")
    for beginning in ("", "You said ", "Noted: "):
        browser.wait_for(f"{TEXT}.includes({beginning + fake.asked!r})", seconds=30)
    foreign = browser.run(
        "performance.getEntriesByType('resource').map(e => new URL(e.name)).filter("
        "u => u.protocol != 'data:' && u.host != location.host).map(u => u.href)"
    )
    assert (asked, foreign) == ([], [])
