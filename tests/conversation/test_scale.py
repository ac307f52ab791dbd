"""The size of a pixel, said beside a question."""

import pytest

from geotlm_lm.conversation.frame_facts import read_facts
from geotlm_lm.conversation.scale import asks_scale, told_scale, with_pixel_size
from geotlm_lm.core.frame_spec import FrameSpec

CAMERA, SCALED = FrameSpec(), FrameSpec(mm_per_px=0.06)


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("How fast in mm/s? One pixel is 0.06 mm.", "How fast in mm/s?"),
        ("did it slide 1 mm? 0.06 mm per pixel", "did it slide 1 mm?"),
        ("How far, at 0.06 mm per pixel?", "How far"),
        ("How far in mm (0.06 mm/px)?", "How far in mm"),
        ("how far with a scale of 60 microns per pixel", "how far"),
        ("how far is it, when each pixel is 60 microns?", "how far is it"),
        ("With 0.06 mm per px, how far does it slide?", "how far does it slide?"),
        ("With a pixel of 0.06 mm, how far?", "how far?"),
    ],
)
def test_the_size_of_a_pixel_said_after_a_question_lasts(text, rest):
    stated = read_facts(text, CAMERA)
    assert stated.frame == stated.lasting == SCALED
    assert (stated.rest, stated.is_stated) == (rest, True)


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("how far in mm if a pixel is 0.06 mm", "how far in mm"),
        ("How far, supposing a pixel were 0.06 mm?", "How far"),
        ("If a pixel is 0.06 mm, how far in mm?", "how far in mm?"),
    ],
)
def test_a_size_that_is_supposed_holds_for_its_question_alone(text, rest):
    before = FrameSpec(mm_per_px=0.1)
    stated = read_facts(text, before)
    assert (stated.frame, stated.lasting, stated.rest) == (SCALED, before, rest)


def test_a_fact_before_a_question_and_a_size_after_it_are_both_read():
    stated = read_facts("The image is mirrored. How far? 0.06 mm per pixel", CAMERA)
    assert stated.frame == FrameSpec(image_mirrored=True, mm_per_px=0.06)
    assert stated.rest == "How far?"


@pytest.mark.parametrize(
    "text",
    [
        "Did it slide 0.06 mm per pixel?",
        "how far? 40 mm per pixel",
        "What if a pixel is 0.06 mm?",
        "The gel is new, 0.06 mm per pixel",
    ],
)
def test_a_size_beside_no_question_or_that_no_camera_has_is_not_read(text):
    assert not read_facts(text, CAMERA).is_stated


@pytest.mark.parametrize(
    "text",
    [
        "Thanks! A pixel is 0.06 mm.",
        "OK, and a pixel is 0.06 mm",
        "Great, thank you. The scale is 0.06 mm per pixel",
    ],
)
def test_a_size_after_a_courtesy_is_a_fact_alone(text):
    stated = read_facts(text, CAMERA)
    assert (stated.lasting, stated.rest, stated.is_stated) == (SCALED, "", True)


@pytest.mark.parametrize(
    "text",
    [
        "Suppose the image is mirrored and a pixel is 0.06 mm, how far?",
        "If a pixel is 0.06 mm, and the image is mirrored, how far?",
    ],
)
def test_a_size_supposed_beside_another_fact_holds_with_it_for_its_question_alone(text):
    stated = read_facts(text, CAMERA)
    assert stated.frame == FrameSpec(image_mirrored=True, mm_per_px=0.06)
    assert (stated.lasting, stated.rest) == (CAMERA, "how far?")


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ("Is the scale 0.06 mm per pixel?", True),
        ("Is one pixel 0.06 mm wide?", True),
        ("Is it 0.06 mm/px?", True),
        ("Is it 10 mm wide?", False),
        ("Is the pixel moving 1 mm?", False),
        ("The scale is 0.06 mm per pixel", False),
    ],
)
def test_a_question_for_the_size_of_a_pixel_is_known(text, asks):
    assert asks_scale(text) is asks


def test_the_size_of_a_pixel_is_told_as_it_was_said_or_asked_for():
    assert told_scale(0.06) == "As it was said, a pixel is 0.06 mm wide on the gel."
    assert told_scale(None).startswith("Nothing tells me how large a pixel is: say ")


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("The image is 16 mm wide. How far?", "How far?"),
        ("The field of view is 16 mm x 12 mm. How many mm?", "How many mm?"),
        ("my camera has 20 pixels per mm. How far?", "How far?"),
        ("The picture shows 16 mm across", ""),
    ],
)
def test_the_size_of_the_whole_picture_is_that_of_its_pixels(text, rest):
    stated = read_facts(with_pixel_size(text, 320), CAMERA)
    assert (stated.lasting, stated.rest) == (FrameSpec(mm_per_px=0.05), rest)


@pytest.mark.parametrize(
    "text",
    ["Is the image 16 mm wide?", "The cap is 16 mm wide.", "The image is 16 mm from the edge."],
)
def test_the_size_of_other_things_is_not(text):
    assert with_pixel_size(text, 320) == text
