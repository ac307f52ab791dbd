"""What is drawn of a clip follows what is answered: without contact there are no arrows."""

from pathlib import Path

import numpy as np
import pytest

from app import handlers
from app.clip_loading import load_clip
from geotlm_lm.views.pictures import ARROW_COLOUR

EXAMPLES = Path(__file__).resolve().parents[2] / "app" / "examples"


@pytest.mark.parametrize(
    ("name", "has_arrows"), [("key_none", False), ("screw_head_down", True), ("bead_right", True)]
)
def test_arrows_are_drawn_of_what_touches_alone(answerer, name, has_arrows):
    shown = load_clip(answerer, str(EXAMPLES / f"{name}.npz"))
    drawn = handlers.draw(shown, "arrows", 4).astype(int)
    yellow = (np.abs(drawn - ARROW_COLOUR) < 40).all(axis=-1)
    assert bool(yellow[:380].any()) is has_arrows  # above the legend
    assert bool(yellow.any()) is has_arrows
