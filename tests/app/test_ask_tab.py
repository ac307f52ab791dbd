"""The conversation of the Ask tab keeps what was typed, however it is shown."""

from types import SimpleNamespace

import pytest

pytest.importorskip("gradio", reason="the page needs gradio (extra: app)")

from app.clip_loading import load_clip  # noqa: E402
from app.opening import Source  # noqa: E402
from app.talking import Talking  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

QUESTION = "Is it <b>5 px</b> &amp; a < b?"
SHOWN = "Is it &lt;b&gt;5 px&lt;/b&gt; &amp;amp; a &lt; b?"


@pytest.mark.parametrize("as_blocks", [False, True], ids=["text", "blocks"])
def test_a_question_is_asked_again_as_it_was_typed(recordings, as_blocks):
    asked, answerer = [], FakeAnswerer()
    answerer.bundle.reader.lines[QUESTION] = "way"
    path = str(recordings["bright"])
    shown, talking = load_clip(answerer, path), Talking(answerer)
    others = (shown, Source(path, "bright.npy"), [], None, "http://127.0.0.1:7860")
    chat = next(talking.ask(QUESTION, [], *others))["chat"]
    assert chat[0]["content"] == SHOWN
    if as_blocks:
        chat[0]["content"] = [{"type": "text", "text": SHOWN}]
    shown.session.take_back = SimpleNamespace(call=asked.append).call
    again = next(talking.again(chat, *others))
    assert asked == [QUESTION]
    assert again["chat"][0]["content"] == SHOWN
    assert "question" not in again  # what is being typed stays
