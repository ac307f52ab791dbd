"""The server fetches nothing for whoever asks: real requests; a downloader that must not run."""

from http.client import HTTPConnection
from urllib.parse import urlsplit

import httpx
import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from gradio import processing_utils  # noqa: E402

from app import no_addresses  # noqa: E402

ADDRESSES = ("http://93.184.216.34/clip.npz", "https://93.184.216.34/clip.npz", "file:///etc/hosts")


@pytest.fixture(autouse=True)
def fetched(monkeypatch):
    """The addresses that were fetched."""
    addresses = []

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


FILES = ("file", "image", "chatbot")


@pytest.mark.parametrize("named", ADDRESSES)
def test_no_input_of_the_page_takes_a_file_by_its_address(address, fetched, named):
    seen = set()
    for number, count, place, kind in inputs_of(address):
        file = {"path": named, "meta": {"_type": "gradio.FileData"}}
        shapes = {"file": file, "image": file, "chatbot": [{"role": "user", "content": file}]}
        data = [None] * count
        data[place] = shapes[kind]
        given = {"data": data, "fn_index": number, "session_hash": f"s{number}"}
        told = httpx.post(f"{address}gradio_api/run/predict", json=given)
        assert (told.status_code, told.json()["error"]) == (500, no_addresses.REFUSED)
        seen.add(kind)
    assert seen == set(FILES)
    assert fetched == []


def test_no_tool_takes_a_file_by_its_address(address, fetched):
    file = {"path": ADDRESSES[0], "meta": {"_type": "gradio.FileData"}}
    call = httpx.post(f"{address}gradio_api/call/v2/evidence", json={"recording": file}).json()
    told = httpx.get(f"{address}gradio_api/call/evidence/{call['event_id']}").text
    assert no_addresses.REFUSED in told
    assert fetched == []


@pytest.mark.parametrize("kind", ["file=http:", "file=HTTPS:", "proxy=http:"])
def test_nothing_is_passed_on_from_elsewhere(address, fetched, kind):
    connection = HTTPConnection(urlsplit(address).netloc, timeout=30)
    connection.request("GET", f"/gradio_api/{kind}//93.184.216.34/clip.npz")
    answer = connection.getresponse()
    assert (answer.status, answer.read().decode().strip()) == (403, no_addresses.REFUSED)
    connection.close()
    assert fetched == []
