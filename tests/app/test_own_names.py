"""A page of another site is refused, whatever name it made mean this machine: real requests."""

import base64
import os
import socket
from http.client import HTTPConnection
from importlib.util import find_spec
from urllib.parse import urlsplit

import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import ui  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

HAS_MCP = find_spec("mcp") is not None
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
def served(tmp_path_factory):
    """The page, with a folder of its own for uploads."""
    folder = tmp_path_factory.mktemp("uploads")
    before = os.environ.get("GRADIO_TEMP_DIR")
    os.environ["GRADIO_TEMP_DIR"] = str(folder)
    page = ui.build(FakeAnswerer())
    address = ui.launch(page, mcp=HAS_MCP)
    yield urlsplit(address).port, folder
    page.close()
    if before is None:
        del os.environ["GRADIO_TEMP_DIR"]
    else:
        os.environ["GRADIO_TEMP_DIR"] = before


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


def calls():
    return [one for one in CALLS if one != "mcp" or HAS_MCP]


@pytest.mark.parametrize("call", calls())
@pytest.mark.parametrize(
    "named",
    [
        {"Host": "attacker.example:{port}"},
        {"Host": "attacker.example:{port}", "Origin": "http://attacker.example:{port}"},
        {"Host": "127.0.0.1:{port}", "Origin": "http://attacker.example"},
        {"Host": "127.0.0.1:{port}", "Origin": "null"},
        {"Host": "127.0.0.1.attacker.example"},
        {"Host": "localhost@attacker.example"},
        {"Host": "[::1"},
        {"Host": "localhost:{port}", "Origin": "http://localhost:9999"},
        {"Host": "localhost:{port}", "Origin": "http://localhost"},
        {"Host": "localhost:{port}", "Origin": "http://127.0.0.1:{port}"},
        {"Host": "localhost:{port}", "Origin": "http://localhost:none"},
        {},
    ],
    ids=[
        *("host", "both", "origin", "opaque", "longer", "user", "unclosed"),
        *("port", "no port", "name", "no number", "none"),
    ],
)
def test_another_site_is_refused_and_leaves_nothing(served, call, named):
    port, folder = served
    before = sorted(folder.rglob("*"))
    given = {name: value.format(port=port) for name, value in named.items()}
    # The server itself refuses a request without a host.
    assert status_of(port, call, **given) == (403 if named else 400)
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("call", calls())
@pytest.mark.parametrize("name", ["localhost", "127.0.0.1", "[::1]", "LOCALHOST"])
def test_the_page_itself_is_served_by_each_of_its_names(served, call, name):
    port, _ = served
    host = f"{name}:{port}"
    # A call that names no clip fails once it is heard, and not before.
    heard = 500 if call == "run" else 200
    assert status_of(port, call, Host=host) == heard
    assert status_of(port, call, Host=host, Origin=f"http://{host}") == heard


def test_the_page_is_served_where_its_port_is_forwarded(served):
    port, _ = served
    assert status_of(port, "call", Host="localhost:9999", Origin="http://localhost:9999") == 200


def test_an_upload_by_its_own_name_is_kept(served):
    port, folder = served
    assert status_of(port, "upload", Host=f"localhost:{port}") == 200
    assert [one.read_bytes() for one in folder.rglob("planted.npz")] == [b"PK\x03\x04"]


def test_a_form_is_refused_before_it_is_sent(served):
    port, _ = served
    with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
        connection.sendall(
            b"POST /gradio_api/upload HTTP/1.1\r\nHost: attacker.example\r\n"
            b"Content-Type: multipart/form-data; boundary=cut\r\nContent-Length: 400000000\r\n\r\n"
        )
        assert connection.recv(12) == b"HTTP/1.1 403"


def test_a_websocket_of_another_site_is_refused(served):
    port, _ = served
    key = base64.b64encode(os.urandom(16)).decode()
    asked = (
        f"GET /gradio_api/queue/join HTTP/1.1\r\nHost: attacker.example\r\nUpgrade: websocket\r\n"
        f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
        connection.sendall(asked.encode())
        assert connection.recv(12) == b"HTTP/1.1 403"
