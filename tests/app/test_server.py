"""The served page and its typed interface, used as a program would: by a real client."""

import time
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np
import pytest

httpx = pytest.importorskip("httpx", reason="asking the page needs httpx (extra: app)")
gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from gradio_client import Client, handle_file  # noqa: E402
from gradio_client.exceptions import AppError  # noqa: E402

from app import ui  # noqa: E402
from app.stage import PACKS  # noqa: E402
from tests.app.fakes import FakeAnswerer, clip  # noqa: E402


@pytest.fixture(scope="module")
def client(address):
    return Client(address, verbose=False)


def test_it_listens_on_this_machine_only(address):
    assert address.startswith("http://127.0.0.1:")


def test_a_question_about_an_upload_is_answered(client, recordings):
    sent = handle_file(recordings["bright"])
    answer = client.predict(sent, "Which way?", api_name="/ask")
    assert (answer["direction"], answer["query"]) == ("right", "way all")
    assert "second_opinions" not in answer  # they are evidence


def test_evidence_comes_without_the_language_model(client, recordings):
    sent = handle_file(recordings["bright"])
    evidence = client.predict(sent, api_name="/evidence")
    assert evidence["contact_share"] == 0.5
    assert np.shape(evidence["shear_change"]) == (14, 14, 2)
    assert set(evidence["second_opinions"]) == {"probe", "optical_flow", "timing_ms"}


def test_pictures_are_fetched_by_an_address_that_nobody_can_guess(address):
    pack = PACKS.address([np.full((48, 64, 3), 90, np.uint8)] * 2)
    answer = httpx.get(f"{address}{pack}")
    assert (answer.status_code, answer.content[:4]) == (200, b"\x02\0\0\0")
    assert PACKS.address([np.full((48, 64, 3), 90, np.uint8)] * 2) == pack
    assert httpx.get(f"{address}frames/{'0' * 32}").status_code == 404


def test_a_file_of_this_machine_that_was_not_uploaded_is_refused(client, path):
    for trick in ({"path": path}, path, {"path": "../../etc/passwd"}):
        with pytest.raises(AppError, match="The recording is neither|There is no recording"):
            client.predict(trick, api_name="/evidence")


def test_a_mistake_is_one_sentence_and_no_trace(client, tmp_path):
    (tmp_path / "text.npy").write_text("no array")
    with pytest.raises(AppError) as caught:
        client.predict(handle_file(tmp_path / "text.npy"), api_name="/evidence")
    assert "text.npy: is cut off or is no numpy file" in str(caught.value)
    assert "Traceback" not in str(caught.value)
    with pytest.raises(AppError, match="seed was None, and input should be a valid integer"):
        client.predict("key", 0.6, 0.0, 1.0, 0.0, 0.0, 4.0, None, api_name="/simulate")


def test_clients_at_once_never_get_each_others_answers(address, tmp_path):
    levels, asked = (40, 70, 130, 190), ["way all", "kind", "extent"]

    def talk(level):
        client = Client(address, verbose=False)
        np.save(tmp_path / f"{level}.npy", clip(level))
        sent = handle_file(tmp_path / f"{level}.npy")
        return [client.predict(sent, one, api_name="/ask") for one in asked]

    with ThreadPoolExecutor(len(levels)) as pool:
        answers = dict(zip(levels, pool.map(talk, levels), strict=True))
    for level, given in answers.items():
        assert [one["query"] for one in given] == asked
        assert {one["direction"] for one in given} == {"right" if level > 100 else "left"}
        for one in given:  # the clip is 64 pixels wide, its view 224
            assert one["amount"]["value"] * 35 == pytest.approx(level, abs=3)


class Slow(FakeAnswerer):
    """Takes as long as it is made to over a recording that is not dark, and lets others in."""

    def __init__(self):
        super().__init__()
        self.began, self.may_end = Event(), Event()

    def encode(self, clip, *, progress, **named):
        if clip.frames.mean() > 100:
            self.began.set()
            while not self.may_end.is_set():
                progress("tracking", 1, 2)
                time.sleep(0.005)
        return super().encode(clip, progress=progress, **named)


@pytest.fixture
def slow():
    slow = Slow()
    page = ui.build(slow)
    slow.address = ui.launch(page)
    yield slow
    slow.may_end.set()
    page.close()


def test_a_long_recording_holds_up_its_own_visitor_and_no_other(slow, recordings):
    bright, dark = (handle_file(recordings[name]) for name in ("bright", "dark"))
    mine, other = (Client(slow.address, verbose=False) for _ in range(2))
    long = mine.submit(bright, "Which way does it go?", api_name="/ask")
    assert slow.began.wait(60)
    next_of_mine = mine.submit(dark, "Which way does it go?", api_name="/ask")
    told = [other.predict(dark, "Which way does it go?", api_name="/ask") for _ in range(3)]
    assert {one["direction"] for one in told} == {"left"}
    assert not long.done()
    assert not next_of_mine.done()
    slow.may_end.set()
    assert long.result(60)["direction"] == "right"
    assert next_of_mine.result(60)["direction"] == "left"
