"""Name the part of the picture where a point lies: "upper left"."""

from __future__ import annotations

OFF_CENTRE_SHARE = 1 / 6
"""Share of the picture's side from its middle beyond which a place is no longer the middle's."""


def place_in_picture(across: float, down: float) -> str:
    """Return the part of the picture that a point lies in, such as "upper left".

    Args:
        across: Share of the width from the left border.
        down: Share of the height from the top.
    """
    parts = (_part(down, "upper", "lower"), _part(across, "left", "right"))
    named = [part for part in parts if part]
    if len(named) == 2:
        return " ".join(named)
    return f"{named[0]} middle" if named else "middle"


def _part(share: float, first: str, last: str) -> str:
    if abs(share - 0.5) <= OFF_CENTRE_SHARE:
        return ""
    return first if share < 0.5 else last
