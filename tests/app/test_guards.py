"""What the server refuses, by real requests: other sites, addresses, and more than memory holds."""

import asyncio
import base64
import gc
import io
import json
import socket
import threading
import time
from http.client import HTTPConnection
from itertools import product
from urllib.parse import urlsplit

import numpy as np
import pytest

httpx = pytest.importorskip("httpx", reason="asking the page needs httpx (extra: app)")
pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")

from app import guards, ui  # noqa: E402
from app.clips import read_named  # noqa: E402
from app.guards import TAKEN, Budget, Busy, Guard  # noqa: E402
from geotlm_lm import GeoTLMError  # noqa: E402
from tests.app.fakes import FakeAnswerer, clip, in_message  # noqa: E402


@pytest.fixture
def small(monkeypatch):
    """A budget as large as two small recordings while they are read."""
    monkeypatch.setattr(guards, "MEMORY", Budget(4 * clip(90).nbytes))
    return guards.MEMORY


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


def test_a_recording_that_fails_gives_its_share_back(small, path, monkeypatch):
    def fail(*_, **__):
        raise GeoTLMError("no")

    monkeypatch.setattr("geotlm_lm.read_clip", fail)
    with pytest.raises(GeoTLMError, match="^no$"):
        read_named(path)
    assert small.taken_bytes == 0


class Kept:
    """Keeps shares until it is asked to let go of them."""

    def __init__(self, shares):
        self.shares = shares

    def let_go(self):
        return bool(self.shares) and not self.shares.pop().resize(0)


def test_what_is_only_kept_goes_first():
    shared = Budget(10)
    kept = Kept([shared.take(3), shared.take(3)])
    shared.may_let_go(kept)
    taken = shared.take(6)
    assert (len(kept.shares), shared.taken_bytes) == (1, 9)
    with pytest.raises(Busy):
        shared.take(5)
    taken.resize(0)
    taken.resize(0)
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
    return (guards.BUSY_STATUS if f'"status":{guards.BUSY_STATUS}' in told.text else 200), told.text


def run(address, level):
    """Return the same where the toolkit's queue is passed by."""
    given = {"data": [message(level), None, None]}
    told = httpx.post(f"{address}gradio_api/run/evidence", json=given, timeout=60)
    return told.status_code, told.text


@pytest.mark.parametrize("call", [called, agent_called, run])
def test_who_finds_the_memory_taken_is_refused_with_429_and_may_come_again(
    small, waiting, call, monkeypatch
):
    monkeypatch.setattr(guards, "SHORT_BYTES", 2**20)  # the recording alone is counted
    address, answerer = waiting
    got = {}

    def ask(level):
        got[level] = call(address, level)

    threads = [threading.Thread(target=ask, args=(level,), daemon=True) for level in (60, 70, 80)]
    for thread in threads:
        thread.start()
        assert answerer.began.acquire(timeout=20)  # it has read its recording
    status, told = call(address, 90)
    assert status == guards.BUSY_STATUS
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
    assert answer.headers["Retry-After"] == str(guards.AGAIN_S)
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


def sent(path, parts, declared=None, name=b"content-length"):
    """Return what an app reads of a request, and the status that is answered."""
    read, status = [], []

    async def app(scope, receive, send):
        while (message := await receive())["type"] == "http.request":
            read.append(message["body"])
            if not message["more_body"]:
                break
        await send({"type": "http.response.start", "status": 200})

    async def receive():
        part = left.pop(0)
        return {"type": "http.request", "body": part, "more_body": bool(left)}

    async def send(message):
        status.append(message.get("status"))

    left = list(parts)
    headers = [(b"host", b"localhost")]
    headers += [] if declared is None else [(name, declared)]
    scope = {"type": "http", "path": path, "headers": headers}
    asyncio.run(Guard(app, 10)(scope, receive, send))
    return b"".join(read), status[0]


@pytest.mark.parametrize("declared", [b"11", b"99999999999999999999", b"-1", b"ten"])
def test_a_message_that_says_it_is_too_long_is_refused_unread(declared):
    assert sent("/gradio_api/call/ask", [b"x"], declared) == (b"", 413)


def test_one_without_a_length_is_refused_unread_and_an_upload_may_be_longer():
    assert sent("/mcp", [b"12345", b"6789"], b"9") == (b"123456789", 200)
    assert sent("/mcp", [b"12345"], b"chunked", b"transfer-encoding") == (b"", 411)
    assert sent("/gradio_api/upload", [b"12345"] * 4, b"20") == (b"12345" * 4, 200)


ADDRESSES = ("http://93.184.216.34/clip.npz", "https://93.184.216.34/clip.npz", "file:///etc/hosts")


@pytest.fixture
def fetched(monkeypatch):
    """The addresses that were fetched."""
    addresses = []

    from gradio import processing_utils

    async def fetch(address, *_):
        addresses.append(address)
        raise ConnectionError(address)

    for name in ("async_ssrf_protected_download", "async_ssrf_protected_get"):
        monkeypatch.setattr(processing_utils, name, fetch)
    return addresses


def inputs_of(address):
    """Return every input of the page that holds files, as the number of a function and its data."""
    config = httpx.get(f"{address}config").json()
    kinds = {one["id"]: one["type"] for one in config["components"]}
    for function in config["dependencies"]:
        places = [place for place, one in enumerate(function["inputs"]) if kinds[one] in FILES]
        for place in places:
            yield function["id"], len(function["inputs"]), place, kinds[function["inputs"][place]]


FILES = ("file", "image")


def test_no_input_of_the_page_takes_a_file_by_its_address(address, fetched):
    seen = set()
    for named, (number, count, place, kind) in product(ADDRESSES, inputs_of(address)):
        file = {"path": named, "meta": {"_type": "gradio.FileData"}}
        shapes = {"file": file, "image": file}
        data = [None] * count
        data[place] = shapes[kind]
        given = {"data": data, "fn_index": number, "session_hash": f"s{number}"}
        told = httpx.post(f"{address}gradio_api/run/predict", json=given)
        assert (told.status_code, told.json()["error"]) == (500, guards.NO_ADDRESSES)
        seen.add(kind)
    assert seen == set(FILES)
    assert fetched == []


def test_no_tool_takes_a_file_by_its_address(address, fetched):
    file = {"path": ADDRESSES[0], "meta": {"_type": "gradio.FileData"}}
    call = httpx.post(f"{address}gradio_api/call/v2/evidence", json={"recording": file}).json()
    told = httpx.get(f"{address}gradio_api/call/evidence/{call['event_id']}").text
    assert guards.NO_ADDRESSES in told
    assert fetched == []


def test_nothing_is_passed_on_from_elsewhere(address, fetched):
    for kind in ("file=http:", "file=HTTPS:", "proxy=http:"):
        answer = httpx.get(f"{address}gradio_api/{kind}//93.184.216.34/clip.npz")
        assert (answer.status_code, answer.text.strip()) == (403, guards.NO_ADDRESSES)
    assert fetched == []


FORM = (
    b'--cut\r\nContent-Disposition: form-data; name="files"; filename="planted.npz"\r\n'
    b"Content-Type: application/octet-stream\r\n\r\nPK\x03\x04\r\n--cut--\r\n"
)
UPLOAD = {"Content-Type": "multipart/form-data; boundary=cut"}
JSON = {"Content-Type": "application/json", "Accept": "application/json, text/event-stream"}
PING = (
    b'{"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {"protocolVersion": '
    b'"2025-03-26", "capabilities": {}, "clientInfo": {"name": "t", "version": "1"}}}'
)
CALLS = {
    "page": ("GET", "/", b"", {}),
    "config": ("GET", "/config", b"", {}),
    "call": ("POST", "/gradio_api/call/simulate", b'{"data": []}', JSON),
    "run": ("POST", "/gradio_api/run/evidence", b'{"data": []}', JSON),
    "upload": ("POST", "/gradio_api/upload", FORM, UPLOAD),
    "mcp": ("POST", "/mcp", PING, JSON),
}


@pytest.fixture(scope="module")
def served(agents_address, uploads):
    """The page's port, and the folder that its uploads lie in."""
    return urlsplit(agents_address).port, uploads


def status_of(port, call, **named):
    """Return the status of a request that names its host, and perhaps its origin, itself."""
    method, path, body, headers = CALLS[call]
    connection = HTTPConnection("127.0.0.1", port, timeout=30)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in (headers | named).items():
        connection.putheader(name, value)
    if body:
        connection.putheader("Content-Length", str(len(body)))
    connection.endheaders(body or None)
    try:
        return connection.getresponse().status
    finally:
        connection.close()


HOST = "127.0.0.1:{port}"
OTHERS = [
    {"Host": "attacker.example:{port}"},
    {"Host": "attacker.example:{port}", "Origin": "http://attacker.example:{port}"},
    {"Host": HOST, "Origin": "http://attacker.example"},
    {"Host": HOST, "Origin": "null"},
    {"Host": "127.0.0.1.attacker.example"},
    {"Host": "localhost@attacker.example"},
    {"Host": "[::1"},
    {"Host": "localhost:{port}", "Origin": "http://localhost:9999"},
    {"Host": "localhost:{port}", "Origin": "http://localhost"},
    {"Host": "localhost:{port}", "Origin": "http://127.0.0.1:{port}"},
    {"Host": "localhost:{port}", "Origin": "http://localhost:none"},
    {},
]


@pytest.mark.parametrize("call", CALLS)
def test_another_site_is_refused_and_leaves_nothing(served, call):
    port, folder = served
    before = sorted(folder.rglob("*"))
    for named in OTHERS:
        given = {name: value.format(port=port) for name, value in named.items()}
        # The server itself refuses a request without a host.
        assert status_of(port, call, **given) == (403 if named else 400), named
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("call", CALLS)
def test_the_page_itself_is_served_by_each_of_its_names(served, call):
    port, _ = served
    # A call that names no clip fails once it is heard, and not before.
    heard = 500 if call == "run" else 200
    names = [f"{name}:{port}" for name in ("localhost", "127.0.0.1", "[::1]", "LOCALHOST")]
    for host in (*names, "localhost:9999"):  # the last one's port is forwarded
        assert status_of(port, call, Host=host) == heard
        assert status_of(port, call, Host=host, Origin=f"http://{host}") == heard


def test_an_upload_by_its_own_name_is_kept(served):
    port, folder = served
    assert status_of(port, "upload", Host=f"localhost:{port}") == 200
    assert [one.read_bytes() for one in folder.rglob("planted.npz")] == [b"PK\x03\x04"]


FORM_OF_ANOTHER = (
    b"POST /gradio_api/upload HTTP/1.1\r\nHost: attacker.example\r\n"
    b"Content-Type: multipart/form-data; boundary=cut\r\nContent-Length: 400000000\r\n\r\n"
)
SOCKET_OF_ANOTHER = (
    b"GET /gradio_api/queue/join HTTP/1.1\r\nHost: attacker.example\r\nUpgrade: websocket\r\n"
    b"Connection: Upgrade\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
    b"Sec-WebSocket-Version: 13\r\n\r\n"
)


@pytest.mark.parametrize("asked", [FORM_OF_ANOTHER, SOCKET_OF_ANOTHER], ids=["form", "socket"])
def test_another_site_is_refused_before_anything_is_sent(served, asked):
    port, _ = served
    with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
        connection.sendall(asked)
        assert connection.recv(12) == b"HTTP/1.1 403"
