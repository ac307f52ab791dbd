"""Twenty at once: everybody gets their own answer, and a full queue says so."""

import json
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

import httpx  # noqa: E402
from gradio_client import Client, handle_file  # noqa: E402

from app import ui  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

USERS = 20
LEVELS = tuple(30 + 10 * number for number in range(USERS))
"""Each user's clip is of another grey level, which the stand-in's answer names."""


@pytest.fixture(scope="module")
def address():
    page = ui.build(FakeAnswerer())
    yield ui.launch(page).rstrip("/")
    page.close()


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clips")
    for level in LEVELS:
        np.save(folder / f"{level}.npy", np.full((4, 16, 20, 3), level, np.uint8))
    return {level: folder / f"{level}.npy" for level in LEVELS}


def told_level(text):
    return float(text.split(" at ")[1].split()[0].rstrip("."))


def test_twenty_programs_at_once_get_their_own_answers(address, clips):
    clients = {level: Client(address, verbose=False) for level in LEVELS}
    together = threading.Barrier(USERS)

    def ask(level):
        together.wait(timeout=120)
        given = handle_file(clips[level])
        return clients[level].predict(given, f"Question {level}?", api_name="/ask")

    with ThreadPoolExecutor(USERS) as pool:
        answers = dict(zip(LEVELS, pool.map(ask, LEVELS), strict=True))
    assert {level: answer["question"] for level, answer in answers.items()} == {
        level: f"Question {level}?" for level in LEVELS
    }
    assert {level: told_level(answer["text"]) for level, answer in answers.items()} == {
        level: level for level in LEVELS
    }


class Visitor:
    """A person at the page: what the browser sends, without the browser."""

    def __init__(self, address, name):
        self._http = httpx.Client(base_url=f"{address}/gradio_api", timeout=120)
        self._name = name
        config = httpx.get(f"{address}/config").json()
        self._places = {one["api_name"]: one for one in config["dependencies"] if one["api_name"]}

    def upload(self, path):
        (stored,) = self._http.post("/upload", files={"files": path.open("rb")}).json()
        return {"path": stored, "orig_name": path.name, "meta": {"_type": "gradio.FileData"}}

    def do(self, event, *given):
        """Return what the last step of an event shows, component by component."""
        joined = {"data": given, "fn_index": self._places[event]["id"], "session_hash": self._name}
        self._http.post("/queue/join", json=joined).raise_for_status()
        with self._http.stream("GET", "/queue/data", params={"session_hash": self._name}) as lines:
            for line in lines.iter_lines():
                message = json.loads(line.removeprefix("data:")) if line else {}
                if message.get("msg") == "process_completed":
                    assert message["success"], message
                    return message["output"]["data"]
        raise AssertionError("the stream ended before the event did")


def test_twenty_people_at_the_page_never_see_each_others_clips(address, clips):
    together = threading.Barrier(USERS)

    def visit(level):
        person = Visitor(address, f"person-{level}")
        together.wait(timeout=120)
        # A state's own place in what is sent stays empty: it never leaves the server.
        person.do("open_clip", [person.upload(clips[level])], "raw", 4, [], 0, None)
        together.wait(timeout=120)
        return person.do("generate", None, f"Question {level}?", [], [], 0)

    with ThreadPoolExecutor(USERS) as pool:
        shown = dict(zip(LEVELS, pool.map(visit, LEVELS), strict=True))
    for level, outputs in shown.items():
        details = next(one for one in outputs if isinstance(one, dict) and "question" in one)
        assert details["question"] == f"Question {level}?"
        assert told_level(details["text"]) == level


def test_a_full_queue_is_told_and_those_in_it_are_served(clips, monkeypatch):
    class SlowAnswerer(FakeAnswerer):
        is_free = threading.Event()

        def ask(self, encoded, question):
            assert self.is_free.wait(timeout=120)
            return super().ask(encoded, question)

    monkeypatch.setattr(ui, "QUEUE", 3)
    page = ui.build(SlowAnswerer())
    address = ui.launch(page)
    try:
        client = Client(address, verbose=False)
        given = handle_file(clips[LEVELS[0]])
        jobs = [client.submit(given, f"{n}?", api_name="/ask") for n in range(8)]
        errors = []
        for job in jobs:  # the ones in the queue wait for the model, the others end at once
            try:
                job.result(timeout=3.0)
            except TimeoutError:
                continue
            except Exception as error:
                errors.append(str(error))
        SlowAnswerer.is_free.set()
        served = [job.result(timeout=120) for job in jobs if not job.exception(timeout=120)]
    finally:
        SlowAnswerer.is_free.set()
        page.close()
    assert errors
    assert all("queue is full" in error.lower() for error in errors)
    assert len(served) == len(jobs) - len(errors)
