import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.recordings.legible import require_legible
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.truth import READABLE_GREY
from geotlm_lm.training.examples import ExampleSet
from geotlm_lm.training.image_damage import FAINT_CONTRAST, damage_clip

IDLE = np.full((32, 32, 3), 120, np.uint8)
TOUCHED = np.stack([IDLE + np.uint8(level) for level in (40, 42, 44, 46)])
CLIP = Clip(TOUCHED, background=IDLE)


def label(motion):
    return MotionLabel(
        motion=motion,
        rotation_deg=0.0,
        slide_x_mm=0.0,
        slide_y_mm=0.0,
        depth_change_mm=0.0,
        contact_fraction=(0.2,) * 4,
        is_readable=True,
    )


def drawn(motion, change_grey, count=120):
    """What becomes of a clip, seed by seed."""
    return [
        damage_clip(CLIP, label(motion), change_grey, np.random.default_rng(seed))
        for seed in range(count)
    ]


def test_damage_changes_pixels_and_keeps_form_and_motion():
    for clip, told in drawn(Motion.LEFT, 100.0):
        assert (clip.frames.shape, clip.frames.dtype) == (TOUCHED.shape, np.uint8)
        assert clip.background.shape == IDLE.shape
        assert told.motion == Motion.LEFT
    assert any((clip.frames != TOUCHED).any() for clip, _ in drawn(Motion.LEFT, 100.0))


def test_a_touch_faded_below_the_noise_is_told_to_be_unreadable():
    plain = READABLE_GREY / FAINT_CONTRAST[0]  # shows even at the faintest
    assert all(told.is_readable for _, told in drawn(Motion.LEFT, 1.01 * plain))
    lost = [clip for clip, told in drawn(Motion.LEFT, READABLE_GREY) if not told.is_readable]
    assert 0 < len(lost) < 120 / 2
    # Only fading loses a motion: there the idle frame stays and the touch comes nearer to it.
    for clip in lost:
        assert (clip.background == IDLE).all()
        assert (clip.frames < TOUCHED).all()
        assert (clip.frames > IDLE).any()


def test_hardly_any_damage_is_worse_than_what_is_still_answered():
    """A clip that would be refused teaches nothing; drifts and dim frames nearly are."""
    refused = 0
    for made in ExampleSet("check", 4, TRAINING_OBJECTS).simulated(0, 0, 4):
        for seed in range(50):
            clip, _ = damage_clip(made.clip, made.label, 50.0, np.random.default_rng(seed))
            try:
                require_legible(clip)
            except UnreadableClip:
                refused += 1
    assert refused <= 0.03 * 4 * 50
