"""A step is taken whole, whatever asks for an end meanwhile."""

import signal
import time
from multiprocessing import get_context

import pytest

from geotlm_lm.core.interrupts import children_killed_on_error, uninterrupted_step


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_until_the_step_is_taken(number):
    done = []

    def step():
        with uninterrupted_step():
            signal.raise_signal(number)
            done.append("step")

    # As a command takes a request to end.
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            step()
        assert signal.getsignal(number) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGTERM, before)
    assert done == ["step"]


def test_outside_a_step_interrupts_arrive_as_ever():
    with uninterrupted_step():
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_an_error_in_a_step_is_told_as_it_is():
    with pytest.raises(ZeroDivisionError), uninterrupted_step():
        raise ZeroDivisionError
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.fixture
def started():
    """Start a process that would wait for a minute; all are ended after the test."""
    made = []

    def start():
        made.append(get_context("spawn").Process(target=time.sleep, args=(60,)))
        made[-1].start()
        return made[-1]

    yield start
    for one in made:
        one.kill()
        one.join()


def test_a_block_that_is_broken_off_ends_what_it_started(started):
    before, inside = started(), []

    def block():
        with children_killed_on_error():
            inside.append(started())
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        block()
    inside[0].join(30)
    assert (before.is_alive(), inside[0].is_alive()) == (True, False)


def test_a_block_that_is_broken_off_ends_nothing_that_others_start_meanwhile(started):
    inside = []

    def block():
        with children_killed_on_error() as all_started:
            inside.append(started())
            all_started()
            inside.append(started())
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        block()
    inside[0].join(30)
    assert [one.is_alive() for one in inside] == [False, True]
