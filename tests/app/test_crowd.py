"""Several programs that ask at once each get their own example's answer."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from gradio_client import Client, handle_file  # noqa: E402

from app import handlers, ui  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

PROGRAMS = 4


def mixed_up(answerer):
    """Count the programs that were not told what their example is told when nobody else asks."""
    page = ui.build(answerer)
    try:
        address = ui.launch(page)
        alone = Client(address, verbose=False)
        clips = handlers.EXAMPLE_CLIPS[:PROGRAMS]

        def ask(client, clip):
            question = handlers.DIRECTION_QUESTION
            return client.predict(handle_file(clip), question, api_name="/ask")["text"]

        right = [ask(alone, clip) for clip in clips]
        clients = [Client(address, verbose=False) for _ in clips]
        with ThreadPoolExecutor(PROGRAMS) as pool:
            told = list(pool.map(ask, clients, clips))
        return sum(one != other for one, other in zip(told, right, strict=True))
    finally:
        page.close()


def test_a_sound_server_gives_everybody_the_right_answer():
    assert mixed_up(FakeAnswerer()) == 0


def test_a_server_that_mixes_answers_up_is_noticed():
    class MixedUp(FakeAnswerer):
        """Answers every question with the clip of the one before."""

        last = None

        def ask(self, encoded, question):
            before, self.last = self.last or encoded, encoded
            return super().ask(before, question)

    levels = {np.load(path)["frames"].mean() for path in handlers.EXAMPLE_CLIPS[:PROGRAMS]}
    assert len(levels) == PROGRAMS
    assert mixed_up(MixedUp()) > 0
