"""Targets that do what none must; sent to another process by their names."""

import os
import time

from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.fuzzing.target import Target

SEED = b"a sound input"


def _of(react):
    def run(data):
        if data != SEED:
            react(data)

    return Target((SEED,), run)


def fails(home):
    def react(data):
        raise ZeroDivisionError("a defect")

    return _of(react)


def dies(home):
    return _of(lambda data: os.abort())


def loops(home):
    def react(data):
        while True:
            pass

    return _of(react)


def waits(home):
    return _of(lambda data: time.sleep(600))


def refuses(home):
    def react(data):
        raise GeoTLMError("This is refused; give another.")

    return _of(react)


def guarded(home):
    """A defect behind four letters: only what is kept on the way gets there."""

    def run(data):
        if data[:1] != b"F":
            return
        if data[1:2] != b"U":
            return
        if data[2:3] == b"Z":
            raise ZeroDivisionError("reached")

    return Target((b"----",), run)


def works_for(seconds):
    def run(data):
        began = time.process_time()
        while time.process_time() - began < seconds:
            pass

    return run
