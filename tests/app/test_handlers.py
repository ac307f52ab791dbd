"""The page's functions, without the page: a clip is shown, questions are answered, errors told."""

from types import SimpleNamespace

import numpy as np
import pytest

from app import handlers, ui
from geotlm_lm import GeoTLMError
from geotlm_lm.backbone.stem import View
from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.recordings.choose import choose_frames


class FakeAnswerer:
    """Perceives a unit shear to the right in the left half of the image."""

    def encode(self, clip, span=None):
        field = np.zeros((1, 14, 14, 2), np.float32)
        field[..., 0] = 1
        mask = np.zeros((1, 14, 14), np.float32)
        mask[:, :, :7] = 1
        geometry = SimpleNamespace(shear_change=field, mask=mask)
        return SimpleNamespace(
            clip=choose_frames(clip, span=span),
            perception=SimpleNamespace(geometry=geometry),
            view=View(),
        )

    def ask(self, encoded, question):
        return SimpleNamespace(
            text="To the right.",
            confidence=0.97,
            abstained=False,
            options={"right": 0.97, "left": 0.03},
            to_dict=lambda: {"text": "To the right."},
        )


@pytest.fixture
def path(tmp_path):
    frames = np.random.default_rng(0).integers(0, 200, (20, 64, 80, 3)).astype(np.uint8)
    np.save(tmp_path / "clip.npy", frames)
    return str(tmp_path / "clip.npy")


def test_a_clip_is_shown_as_its_four_frames_with_notes(path):
    shown = handlers.show_clip(FakeAnswerer(), path, 3, 9)
    assert [caption for _, caption in shown.frames] == ["frame 3", "frame 5", "frame 7", "frame 9"]
    assert "- Frames 3, 5, 7, 9 are used." in shown.notes


def test_an_answer_is_shown_with_its_probabilities(path):
    answerer = FakeAnswerer()
    reply = handlers.ask(answerer, handlers.show_clip(answerer, path, None, None), "Which way?")
    assert reply.sentence == "To the right.  (97 % sure)"
    assert reply.probabilities == {"right": 0.97, "left": 0.03}


def test_arrows_are_drawn_only_where_there_is_contact(path):
    shown = handlers.show_clip(FakeAnswerer(), path, 3, 9)
    yellow = (np.abs(shown.arrows.astype(int) - handlers.ARROW_COLOUR) < 30).all(axis=-1)
    assert yellow[:, :224].sum() > 500
    assert yellow[:, 260:].sum() < 10


def test_a_field_of_nothing_draws_nothing():
    frame = np.full((20, 30, 3), 9, np.uint8)
    image = handlers.draw_arrows(frame, np.zeros((4, 5, 2)), np.zeros((4, 5)))
    assert (image == 9).all()


def test_nothing_uploaded_is_told():
    with pytest.raises(GeoTLMError, match="^No recording was given; upload a clip first.$"):
        handlers.show_clip(FakeAnswerer(), None, None, None)


def test_an_unreadable_upload_is_told_by_its_own_name(tmp_path):
    (tmp_path / "text.npy").write_text("no array")
    with pytest.raises(GeoTLMError, match="^text.npy: is cut off or is no numpy file"):
        handlers.show_clip(FakeAnswerer(), str(tmp_path / "text.npy"), None, None)


def test_half_a_span_is_told(path):
    with pytest.raises(GeoTLMError, match="^Only one end of the span was given"):
        handlers.show_clip(FakeAnswerer(), path, 3, None)


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
