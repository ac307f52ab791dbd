"""Requests share the memory: who finds it taken is refused by status 429, and it is given back."""

import base64
import gc
import io
import json
import threading
import time
from http.client import HTTPConnection
from urllib.parse import urlsplit

import httpx
import numpy as np
import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import budget, clip_loading, message_limit, opened, ui  # noqa: E402
from app.budget import TAKEN, Budget, Busy  # noqa: E402
from app.clip_loading import read_named  # noqa: E402
from geotlm_lm import GeoTLMError  # noqa: E402
from tests.app.agent_calls import clip, in_message  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402


@pytest.fixture
def small(monkeypatch):
    """A budget as large as two small recordings while they are read."""
    shared = Budget(4 * clip(90).nbytes)
    for module in (clip_loading, opened, message_limit):
        monkeypatch.setattr(module, "WORKING", shared)
    return shared


@pytest.fixture
def path(tmp_path):
    np.save(tmp_path / "clip.npy", clip(90))
    return str(tmp_path / "clip.npy")


def test_a_recording_holds_its_share_for_as_long_as_it_is_in_memory(small, path):
    first = read_named(path)
    assert small.taken_bytes == first.frames.nbytes
    part = first.frames[2:4]
    second, third = read_named(path), read_named(path)
    with pytest.raises(Busy, match=f"^{TAKEN}$"):
        read_named(path)
    del first, second
    assert small.taken_bytes == 2 * third.frames.nbytes  # a part holds all of it
    del third, part
    gc.collect()
    assert small.taken_bytes == 0


def test_a_recording_that_fails_gives_its_share_back(small, tmp_path, monkeypatch):
    np.save(tmp_path / "clip.npy", clip(90))

    def fail(*_, **__):
        raise GeoTLMError("no")

    monkeypatch.setattr(clip_loading, "read_clip", fail)
    with pytest.raises(GeoTLMError, match="^no$"):
        read_named(str(tmp_path / "clip.npy"))
    assert small.taken_bytes == 0


class Kept:
    """Keeps shares until it is asked to let go of them."""

    def __init__(self, shares):
        self.shares = shares

    def let_go(self):
        return bool(self.shares) and not self.shares.pop().close()


def test_what_is_only_kept_goes_first():
    shared = Budget(10)
    kept = Kept([shared.take(3), shared.take(3)])
    shared.may_let_go(kept)
    taken = shared.take(6)
    assert (len(kept.shares), shared.taken_bytes) == (1, 9)
    with pytest.raises(Busy):
        shared.take(5)
    taken.close()
    taken.close()
    assert (kept.shares, shared.take(99).is_kept, shared.taken_bytes) == ([], False, 10)


class Waiting(FakeAnswerer):
    """Looks at a recording for as long as it is made to."""

    def __init__(self):
        super().__init__()
        self.began, self.may_end = threading.Semaphore(0), threading.Event()

    def encode(self, clip, **named):
        self.began.release()
        self.may_end.wait(60)
        return super().encode(clip, **named)


@pytest.fixture
def waiting(monkeypatch):
    """A server whose requests wait, and its model; requests do not wait for each other."""
    answerer = Waiting()
    monkeypatch.setattr(ui, "AnswererInTurns", lambda model, _: model)
    page = ui.build(answerer)
    yield ui.launch(page, mcp=True), answerer
    answerer.may_end.set()
    page.close()


def message(level):
    stored = io.BytesIO()
    np.save(stored, clip(level))
    return in_message(stored.getvalue())


def called(address, level):
    """Return status and text of a tool's answer over REST."""
    url = f"{address}gradio_api/call"
    call = httpx.post(f"{url}/v2/evidence", json={"recording": message(level)})
    if call.status_code != 200:
        return call.status_code, call.text
    told = httpx.get(f"{url}/evidence/{call.json()['event_id']}", timeout=60)
    return told.status_code, told.text


def agent_called(address, level):
    """Return the same over the agents' protocol."""
    call = {"name": "evidence", "arguments": {"recording": message(level)}}
    asked = {"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": call}
    accepted = {"Accept": "application/json, text/event-stream"}
    told = httpx.post(f"{address}mcp", json=asked, headers=accepted, timeout=60)
    assert told.status_code == 200  # as for any mistake of a tool: the session goes on
    return (budget.STATUS if f'"status":{budget.STATUS}' in told.text else 200), told.text


def run(address, level):
    """Return the same where the toolkit's queue is passed by."""
    given = {"data": [message(level), None, None]}
    told = httpx.post(f"{address}gradio_api/run/evidence", json=given, timeout=60)
    return told.status_code, told.text


@pytest.mark.parametrize("call", [called, agent_called, run])
def test_who_finds_the_memory_taken_is_refused_with_429_and_may_come_again(
    small, waiting, call, monkeypatch
):
    monkeypatch.setattr(message_limit, "SHORT_BYTES", 2**20)  # the recording alone is counted
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    address, answerer = waiting
    got = {}

    def ask(level):
        got[level] = call(address, level)

    threads = [threading.Thread(target=ask, args=(level,), daemon=True) for level in (60, 70, 80)]
    for thread in threads:
        thread.start()
        assert answerer.began.acquire(timeout=20)  # it has read its recording
    status, told = call(address, 90)
    assert status == budget.STATUS
    assert TAKEN in json.dumps(told)
    answerer.may_end.set()
    for thread in threads:
        thread.join(60)
    assert {status for status, _ in got.values()} == {200}
    # What was only kept for the next question makes room.
    assert call(address, 90)[0] == 200


def test_a_message_is_refused_unread_where_there_is_no_memory_for_it(small, address):
    connection = HTTPConnection(urlsplit(address).netloc, timeout=30)
    connection.putrequest("POST", "/gradio_api/call/ask")
    connection.putheader("Content-Length", str(2**20))
    with small.held(1):
        connection.endheaders()
        answer = connection.getresponse()
    assert (answer.status, answer.read().decode().strip()) == (429, TAKEN)
    assert answer.headers["Retry-After"] == str(budget.AGAIN_S)
    connection.close()


def test_a_message_gives_its_share_back_however_it_ends(small, address, monkeypatch):
    monkeypatch.setattr(small, "_most", 2**30)
    long = "data:;base64," + base64.b64encode(bytes(2**20)).decode()
    for given in (long, long[:-3], {"path": long}, [long]):
        call = httpx.post(f"{address}gradio_api/call/v2/evidence", json={"recording": given})
        if call.status_code == 200:
            number = call.json()["event_id"]
            httpx.get(f"{address}gradio_api/call/evidence/{number}", timeout=60)
    until = time.monotonic() + 20
    while small.taken_bytes and time.monotonic() < until:  # the toolkit ends it a moment later
        gc.collect()
    assert small.taken_bytes == 0
