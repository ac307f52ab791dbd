"""The tour of the page says what it needs, and its crowd notices a mixed-up answer."""

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import tour, ui  # noqa: E402
from geotlm_lm.core.errors import MissingDependency  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402


def test_a_missing_browser_is_one_sentence(monkeypatch):
    monkeypatch.setattr(tour, "EXECUTABLE", None)
    with pytest.raises(MissingDependency) as caught:
        tour.tour()
    assert str(caught.value) == (
        "A tour of the page needs a Chromium, which was not found; on Debian run "
        "`apt-get install chromium`."
    )


def crowd_of(answerer):
    page = ui.build(answerer)
    try:
        return tour.crowd(ui.launch(page), users=4)
    finally:
        page.close()


def test_a_sound_server_gives_everybody_the_right_answer():
    seen = crowd_of(FakeAnswerer())
    assert (seen["users"], seen["wrong"]) == (4, 0)
    assert 0 < seen["median_s"] <= seen["all_s"]


def test_a_server_that_mixes_answers_up_is_noticed():
    class MixedUp(FakeAnswerer):
        """Answers every question with the clip of the one before."""

        last = None

        def ask(self, encoded, question):
            before, self.last = self.last or encoded, encoded
            return super().ask(before, question)

    levels = {np.load(path)["frames"].mean() for path in tour.handlers.EXAMPLE_CLIPS}
    assert len(levels) == len(tour.handlers.EXAMPLE_CLIPS)
    assert crowd_of(MixedUp())["wrong"] > 0
