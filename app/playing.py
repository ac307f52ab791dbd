"""A button that plays a clip's four frames in a loop, by moving the slider that chooses one."""

from __future__ import annotations

from typing import Any

from geotlm_lm.core.geometry import FRAME_COUNT

FRAME_S = 0.4
"""Time each frame is shown; a press or a turn is followed by eye at this rate."""

NEXT = f"number => number % {FRAME_COUNT} + 1"
"""Which frame comes next, worked out in the page itself."""


def add_play_button(gr: Any, number: Any) -> None:
    """Lay the button out beside the slider `number`, from 1 to `FRAME_COUNT`, and connect it."""
    button = gr.Button("Play", size="sm", min_width=80)
    timer = gr.Timer(FRAME_S, active=False)

    def toggle(label: str) -> tuple[Any, Any]:
        starts = label == "Play"
        return gr.Timer(active=starts), gr.Button("Pause" if starts else "Play")

    button.click(toggle, button, [timer, button], api_visibility="private")
    timer.tick(None, number, number, js=NEXT, api_visibility="private")
