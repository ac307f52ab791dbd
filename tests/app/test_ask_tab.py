"""The conversation of the Ask tab keeps what was typed, however it is shown."""

from types import SimpleNamespace

import pytest

pytest.importorskip("gradio", reason="the page needs gradio (extra: app)")

from app import ask_tab  # noqa: E402
from app.clip_loading import load_clip  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

QUESTION = "Is it <b>5 px</b> &amp; a < b?"
SHOWN = "Is it &lt;b&gt;5 px&lt;/b&gt; &amp;amp; a &lt; b?"


@pytest.mark.parametrize("as_blocks", [False, True], ids=["text", "blocks"])
def test_a_question_is_asked_again_as_it_was_typed(recordings, as_blocks):
    asked = []
    session = SimpleNamespace(take_back=asked.append)
    answerer = FakeAnswerer()
    answerer.bundle.reader.lines[QUESTION] = "way"
    shown = load_clip(answerer, str(recordings["bright"]))
    chat = next(ask_tab._answer(answerer, shown, QUESTION, [], [], None))[0]
    assert chat[0]["content"] == SHOWN
    if as_blocks:
        chat[0]["content"] = [{"type": "text", "text": SHOWN}]
    steps = ask_tab._retry(answerer, shown, "Another?", chat, [], None)
    shown.session.take_back = session.take_back
    again = next(steps)[0]
    assert asked == [QUESTION]
    assert again[0]["content"] == SHOWN
