"""The model is loaded once and handed on in the order it is asked for; long work lets others in."""

import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from threading import Thread
from types import SimpleNamespace

import pytest

from app.turns import LISTENER, AnswererInTurns, LazyAnswerer, Stopped, Turns, reported
from geotlm_lm import Session
from geotlm_lm.core.errors import IncompatibleBundle
from tests.app.fakes import FakeAnswerer
from tests.track.recordings import there_and_back


def started(work, turns, waiting):
    """Start a thread and return it once so many stand in line."""
    thread = Thread(target=work, daemon=True)
    thread.start()
    deadline = time.monotonic() + 60
    while turns.waiting < waiting:
        assert time.monotonic() < deadline
        time.sleep(0.001)
    return thread


def in_line(turns, order, names):
    """Start threads that note their names, each at its turn."""

    def work(name):
        with turns.turn():
            order.append(name)

    return [
        started(lambda name=name: work(name), turns, place)
        for place, name in enumerate(names, start=1)
    ]


def test_turns_are_handed_on_in_the_order_in_which_they_were_asked_for():
    turns, order = Turns(), []
    with turns.turn():
        threads = in_line(turns, order, "abcd")
        assert order == []
    for thread in threads:
        thread.join()
    assert order == list("abcd")
    assert turns.waiting == 0


@pytest.mark.parametrize(("slice_s", "expected"), [(0.0, "1ab2"), (1e9, "12ab")])
def test_long_work_lets_all_that_wait_go_first_once_its_slice_is_over(slice_s, expected):
    turns, order = Turns(slice_s=slice_s), []
    with turns.turn() as turn:
        order.append("1")
        threads = in_line(turns, order, "ab")
        turn.progress("tracking", 1, 2)
        order.append("2")
    for thread in threads:
        thread.join()
    assert order == list(expected)


def test_a_turn_is_given_back_when_the_work_fails():
    turns = Turns()
    with pytest.raises(ZeroDivisionError), turns.turn():
        raise ZeroDivisionError
    with turns.turn():
        pass


def test_who_waits_is_told_the_place_in_the_line(monkeypatch):
    monkeypatch.setattr("app.turns.REPORTED_EVERY_S", 0.001)
    told = []
    turns = Turns(lambda *one: told.append(one))
    with turns.turn():
        thread = started(lambda: turns.turn().__enter__(), turns, 1)
        deadline = time.monotonic() + 60
        while not told:
            assert time.monotonic() < deadline
            time.sleep(0.001)
    thread.join()
    assert told[0] == ("waiting for the model, 1 before you", 0, 1)


def failing(what, done, total):
    """Fail as a page that was closed while it waited."""
    if what.startswith("waiting") and threading.current_thread().name != "patient":
        raise ConnectionError(what)


def test_who_cannot_be_told_the_place_leaves_the_line(monkeypatch):
    monkeypatch.setattr("app.turns.REPORTED_EVERY_S", 0.001)
    turns, failed = Turns(failing), []

    def work():
        with pytest.raises(ConnectionError), turns.turn():
            pass
        failed.append(turns.waiting)

    with turns.turn():
        started(work, turns, 0).join(60)
    assert failed == [0]
    with turns.turn():
        pass


def test_long_work_that_fails_in_line_gives_nobody_elses_turn_away(monkeypatch):
    monkeypatch.setattr("app.turns.REPORTED_EVERY_S", 0.001)
    turns, has_failed, order = Turns(failing, slice_s=0.0), threading.Event(), []

    def work(name):
        threading.current_thread().name = "patient"
        with turns.turn():
            if name == "question":
                has_failed.wait(60)
            order.append(name)

    def track(threads):
        with turns.turn() as turn:
            threads.append(started(lambda: work("question"), turns, 1))
            turn.progress("tracking", 1, 2)

    threads = []
    with pytest.raises(ConnectionError):
        track(threads)
    threads.append(started(lambda: work("next"), turns, 0))
    threads[1].join(0.1)
    has_failed.set()
    for thread in threads:
        thread.join()
    assert order == ["question", "next"]


def test_a_question_is_answered_between_two_frames_of_somebody_elses_recording():
    turns, order = Turns(slice_s=0.0), []
    recording = there_and_back()

    class Tracking(FakeAnswerer):
        def track(self, recording, *, progress):
            for number in range(3):
                order.append(f"frame {number}")
                if number == 1:
                    threads.append(started(ask, turns, 1))
                progress("tracking", number, 3)

        def ask(self, encoded, question, **named):
            order.append("question")

    shared, threads = AnswererInTurns(Tracking(), turns), []

    def ask():
        shared.ask(None, "Which way?")

    shared.track(recording)
    threads[0].join()
    assert order == ["frame 0", "frame 1", "question", "frame 2"]


def test_a_conversation_and_a_camera_wait_for_their_turn_too():
    turns = Turns()
    shared = AnswererInTurns(FakeAnswerer(), turns)
    clip = there_and_back()
    session, tracker = shared.session(shared.encode(clip)), shared.tracker()
    done = []
    with turns.turn():
        threads = [
            started(lambda: done.append(session.ask("Which way does it go?").text), turns, 1),
            started(lambda: done.append(tracker.feed(clip.frames[0], 0.0)), turns, 2),
        ]
        assert done == []
    for thread in threads:
        thread.join()
    assert len(done) == 2
    assert [turn.question for turn in session.history] == ["Which way does it go?"]


def test_nothing_is_loaded_until_it_is_used_and_then_once_for_all():
    loads = []

    def slowly():
        time.sleep(0.05)
        loads.append(1)
        return SimpleNamespace(name="model")

    model = LazyAnswerer(slowly)
    assert not loads
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(lambda _: model.name, range(8))) == ["model"] * 8
    assert len(loads) == 1


def test_a_model_that_cannot_be_loaded_says_so_every_time():
    tries = []

    def fails():
        tries.append(1)
        raise IncompatibleBundle("this installation has no model bundle.")

    model = LazyAnswerer(fails)
    for _ in range(2):
        with pytest.raises(IncompatibleBundle, match="no model bundle"):
            _ = model.bundle
    assert len(tries) == 2


@pytest.mark.slow
def test_the_page_is_built_without_the_models_libraries():
    code = (
        "import sys; from app.turns import LazyAnswerer; from app.ui import build; "
        "build(LazyAnswerer(lambda: 1 / 0)); "
        "print([name for name in ('torch', 'transformers') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_what_reports_how_far_it_is_returns_its_result_and_ends_once_it_is_stopped():
    ended = []

    def work():
        for number in range(10**6):
            try:
                LISTENER.get()("tracking", number, 100)
            except Stopped:
                ended.append(number)
                raise
            time.sleep(0.001)

    def counted():
        return (yield from reported(lambda: len("done"), lambda *report: report))

    steps = reported(work, lambda what, done, total: (what, done / total))
    assert next(steps) == ("tracking", 0.0)
    steps.close()
    until = time.monotonic() + 10
    while not ended and time.monotonic() < until:
        time.sleep(0.01)
    assert ended
    with pytest.raises(StopIteration) as result:
        next(counted())
    assert result.value.value == 4


def test_a_question_that_is_stopped_leaves_no_trace(monkeypatch):
    shared = AnswererInTurns(FakeAnswerer(), Turns())
    session = shared.session(FakeAnswerer().encode(there_and_back()))
    ask = Session.ask

    def stopped_meanwhile(plain, question):
        answer = ask(plain, question)
        session.stop()
        return answer

    session.ask("Which way does it go?")
    with monkeypatch.context() as patch:
        patch.setattr(Session, "ask", stopped_meanwhile)
        with pytest.raises(Stopped):
            session.ask("How far did it go?")
    session.ask("Which way is it moving?")
    asked = [turn.question for turn in session.history]
    assert asked == ["Which way does it go?", "Which way is it moving?"]
