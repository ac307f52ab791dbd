"""The served page and its typed interface, used as a program would: by a real client."""

import base64
import time
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from gradio_client import Client, handle_file  # noqa: E402
from gradio_client.exceptions import AppError  # noqa: E402

from app import ui  # noqa: E402
from tests.app.fakes import FakeAnswerer, clip  # noqa: E402


@pytest.fixture(scope="module")
def client(address):
    return Client(address, verbose=False)


def saved(folder, name, level):
    np.save(folder / name, clip(level))
    return folder / name


def test_it_listens_on_this_machine_only(address):
    assert address.startswith("http://127.0.0.1:")


def test_a_question_about_an_upload_is_answered(client, tmp_path):
    sent = handle_file(saved(tmp_path, "bright.npy", 150))
    answer = client.predict(sent, "Which way?", api_name="/ask")
    assert (answer["direction"], answer["query"]) == ("right", "way")
    assert "second_opinions" not in answer  # they are evidence


def test_evidence_comes_without_the_language_model(client, tmp_path):
    sent = handle_file(saved(tmp_path, "bright.npy", 150))
    evidence = client.predict(sent, api_name="/evidence")
    assert evidence["contact_share"] == 0.5
    assert np.shape(evidence["shear_change"]) == (14, 14, 2)
    assert set(evidence["second_opinions"]) == {"probe", "optical_flow", "timing_ms"}


def test_what_is_left_out_is_as_documented_and_what_is_named_holds(client):
    bright = ("example:bead_right", "Which way does it go?")
    plain = client.predict(*bright, api_name="/ask")
    behind = client.predict(*bright, viewpoint="object", frames=[0, 2], api_name="/ask")
    assert {plain["direction"], behind["direction"]} == {"left", "right"}
    assert behind["frames_used"][-1] == 2


def test_a_track_and_a_picture_come_as_plain_values(client):
    track = client.predict("example:bead_right", api_name="/track")
    assert (track["totals"]["frames"], track["first_frame"]) == (4, 0)
    drawn = client.predict("example:bead_right", "contact", api_name="/picture")
    assert base64.b64decode(drawn["png_base64"]).startswith(b"\x89PNG")


def test_a_topic_of_an_uploaded_bag_is_chosen_by_name(client, bag):
    told = [
        client.predict(handle_file(bag), "Which way?", topic=one, api_name="/ask")["direction"]
        for one in ("/left", "/right")
    ]
    assert told == ["right", "left"]
    with pytest.raises(AppError, match="expected one; give it as `topic`, "):
        client.predict(handle_file(bag), api_name="/track")


def test_two_uploads_are_compared(client, tmp_path):
    clips = [handle_file(saved(tmp_path, f"{level}.npy", level)) for level in (150, 60)]
    assert client.predict(*clips, api_name="/compare")["relation"] == "opposite"


def test_a_touch_is_simulated_and_judged(client):
    facts = client.predict("key", 0.6, 0.0, 1.0, 0.0, 0.0, 4.0, 1, api_name="/simulate")
    assert facts["true_motion"] == "right"
    assert set(facts["error"]) == {"rotation_deg", "slide_x_px", "slide_y_px", "press_mm"}


def test_a_file_of_this_machine_that_was_not_uploaded_is_refused(client, tmp_path):
    path = saved(tmp_path, "private.npy", 150)
    for trick in ({"path": str(path)}, str(path), {"path": "../../etc/passwd"}):
        with pytest.raises(AppError, match="The recording is neither|There is no recording"):
            client.predict(trick, api_name="/evidence")


def test_a_mistake_is_one_sentence_and_no_trace(client, tmp_path):
    (tmp_path / "text.npy").write_text("no array")
    with pytest.raises(AppError) as caught:
        client.predict(handle_file(tmp_path / "text.npy"), api_name="/evidence")
    assert "text.npy: is cut off or is no numpy file" in str(caught.value)
    assert "Traceback" not in str(caught.value)
    with pytest.raises(AppError, match="There is no shape 'unicorn'"):
        client.predict("unicorn", 0.6, 0.0, 1.0, 0.0, 0.0, 4.0, 1, api_name="/simulate")
    for tool in ("/track", "/evidence"):
        with pytest.raises(AppError, match="Frames 1:9 were asked for, expected FIRST < LAST wit"):
            client.predict("example:bead_right", frames=[1, 9], api_name=tool)
    with pytest.raises(AppError, match="seed was None, and input should be a valid integer"):
        client.predict("key", 0.6, 0.0, 1.0, 0.0, 0.0, 4.0, None, api_name="/simulate")


def test_clients_at_once_never_get_each_others_answers(address, tmp_path):
    levels, asked = (40, 70, 130, 190), ["way", "kind", "amount"]
    clips = {level: saved(tmp_path, f"{level}.npy", level) for level in levels}

    def talk(level):
        client = Client(address, verbose=False)
        sent = handle_file(clips[level])
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
    return Slow()


@pytest.fixture
def slow_address(slow):
    page = ui.build(slow)
    yield ui.launch(page)
    slow.may_end.set()
    page.close()


def test_a_long_recording_holds_up_its_own_visitor_and_no_other(slow_address, slow, tmp_path):
    bright, dark = (
        handle_file(saved(tmp_path, f"{name}.npy", level))
        for name, level in (("bright", 150), ("dark", 60))
    )
    mine, other = (Client(slow_address, verbose=False) for _ in range(2))
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
