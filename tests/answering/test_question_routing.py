"""What is answered before, beside or after the model: places, amounts claimed, two questions."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.backbone.view import View
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import Perception
from tests.answering.scripted import answerer_saying, believed, measuring, recording


def test_where_the_contact_is_is_read_off_the_mask(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."}, contact_threshold=0.0)
    answer = answerer.ask(answerer.encode(recording()), "Where is the contact?")
    assert answer.text.startswith("In the middle of the camera image: its middle is around ")
    assert (answer.kind, answer.abstained, answer.direction) == ("contact", False, None)
    blind = answerer_saying(bundle, {"*": "Left, in the camera image."}, contact_threshold=1.1)
    assert blind.ask(blind.encode(recording()), "Where is the contact?").abstained


def test_facts_that_were_read_before_a_turn_that_lacks_something_hold(bundle):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."})
    session = answerer.session(answerer.encode(recording()))
    asked = session.ask("The image is mirrored. The camera is mounted sideways. Which way?")
    assert (asked.abstained, session.frame) == (True, FrameSpec(image_mirrored=True))


@pytest.mark.parametrize("said", ["A slide.", "A rotation."])
def test_the_kind_of_motion_is_what_is_felt(bundle, said):
    for ways, text in (
        (("clockwise",), "A rotation."),
        (("left", "press"), "A slide and a press."),
    ):
        answerer = answerer_saying(bundle, {"*": said}, belief=believed(*ways))
        answer = answerer.ask(answerer.encode(recording()), "What kind of motion is it?")
        assert answer.text == text


def test_a_claim_in_pixels_is_judged_in_pixels_whatever_their_size(bundle):
    answerer = measuring(bundle, "left", px=14.0)
    answer = answerer.ask(
        answerer.encode(recording()), "Did it slide more than 1 px?", frame=FrameSpec(mm_per_px=0.1)
    )
    assert (answer.decided, answer.amount.unit) == ("yes", "px")


def touched_at(row, column, rows=240, columns=320):
    """A clip whose mask is 1 in one patch of a view over the whole image."""
    clip = recording()
    frames = np.zeros((len(clip), rows, columns, 3), np.uint8)
    mask = torch.zeros(1, 14, 14)
    mask[0, row, column] = 1
    with torch.no_grad():
        geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), torch.zeros(1, 14, 14, 2), mask)
    token, (filled_rows, filled_columns) = torch.zeros(1, 4), filled_size(rows, columns)
    view = View(picture_height_px=filled_rows, picture_width_px=filled_columns)
    perception = Perception(token, geometry, token, (view,), None)
    return Encoded(replace(clip, frames=frames, background=frames[0]), perception, {})


@pytest.mark.parametrize(
    ("patch", "size", "part", "centre"),
    [
        ((1, 2), (240, 320), "upper left", (57, 26)),
        ((7, 12), (240, 320), "right middle", (286, 129)),
        ((7, 6), (480, 640), "middle", (297, 257)),
        # Idle gel fills up a square that a portrait picture leaves: it begins at 49 of 224.
        ((12, 9), (320, 240), "lower right", (196, 286)),
    ],
)
def test_the_contact_is_in_its_place_in_the_picture_whatever_was_looked_at(
    bundle, patch, size, part, centre
):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera image."}, contact_threshold=0.0)
    answer = answerer.ask(touched_at(*patch, *size), "Where is the contact?")
    told = f"In the {part} of the camera image: its middle is around {centre[0]} px from the left"
    assert answer.text.startswith(told)
    assert answer.evidence["contact_centre_px"] == pytest.approx(centre, abs=1)
    assert "covers about 1% of the image" in answer.text
