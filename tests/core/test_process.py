"""A step is taken whole, whatever asks for an end meanwhile."""

import signal

import pytest

from geotlm_lm.core.process import uninterrupted_step


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
