"""Recordings as agents give them, and what they get back when something is wrong."""

import base64

import numpy as np

CAP = "example:bottle_cap_clockwise"


def clip(level):
    frames = np.full((6, 48, 64, 3), level, np.uint8)
    frames[3:, 20:30, 20:30] += 9
    return frames


def in_message(stored):
    return "data:;base64," + base64.b64encode(stored).decode()


def assert_refused(told, begins):
    (part,) = told.content
    assert told.isError
    assert part.text.startswith(begins)
    assert "\n" not in part.text
    assert "Traceback" not in part.text
