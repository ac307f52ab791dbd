"""The one rule for frames that are asked for by their numbers, wherever they are asked for."""

from __future__ import annotations

from geotlm_lm.core.errors import UsageError


def require_inside(first: int, last: int, lowest: int, highest: int) -> None:
    """Refuse a span of frames that runs backwards or leaves the recording; nothing is clamped.

    Args:
        first: Number of the first frame that is asked for.
        last: Of the last one.
        lowest: Of the recording's first frame.
        highest: Of its last.

    Raises:
        UsageError: If it does.
    """
    if not lowest <= first < last <= highest:
        raise UsageError(
            f"Frames {first}:{last} were asked for, expected FIRST < LAST within "
            f"{lowest}:{highest}; give frame numbers inside the recording."
        )
