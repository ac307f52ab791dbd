"""A button that plays a clip's four frames in a loop, by moving the slider that chooses one."""

from __future__ import annotations

from typing import Any

FRAME_S = 0.4
"""Time each frame is shown; a press or a turn is followed by eye at this rate."""


def add_play_button(gr: Any, number: Any) -> None:
    """Lay the button out, and let it move the slider `number`, which counts from 1."""
    button = gr.Button("Play", size="sm", min_width=80)
    timer = gr.Timer(FRAME_S, active=False)

    def toggle(label: str) -> tuple[Any, Any]:
        starts = label == "Play"
        return gr.Timer(active=starts), gr.Button("Pause" if starts else "Play")

    button.click(toggle, button, [timer, button], api_visibility="private")
    # Which frame comes next is worked out in the page itself.
    following = f"number => number % {number.maximum} + 1"
    timer.tick(None, number, number, js=following, api_visibility="private")
