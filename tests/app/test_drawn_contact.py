"""What is drawn of a clip follows what is answered: without contact there are no arrows."""

from pathlib import Path

import pytest

from app import stage
from app.clip_loading import load_clip

EXAMPLES = Path(__file__).resolve().parents[2] / "app" / "examples"


@pytest.mark.parametrize(
    ("name", "has_arrows"), [("key_none", False), ("screw_head_down", True), ("bead_right", True)]
)
def test_arrows_are_drawn_of_what_touches_alone(answerer, name, has_arrows):
    told = stage.stage_of(load_clip(answerer, str(EXAMPLES / f"{name}.npz")), name)
    (field,) = told["overlays"]["fields"]
    assert bool(field["ends"]) is has_arrows
    assert bool(told["step"]["rows"]) is has_arrows
