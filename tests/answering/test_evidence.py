"""The regions beside an answer are those of the field it was pooled from, each by its own name."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.encoded import regions_of as evidence
from geotlm_lm.backbone.view import View
from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import Perception
from geotlm_lm.recordings.read import read_clip
from tests.answering.scripted import feeling, recording
from tests.tiny_bundle import tiny_bundle


def test_every_region_has_its_own_means_of_the_shear_change():
    field = torch.zeros(1, 14, 14, 2)
    field[:, :7, :, 0] = 1.0  # the upper half goes to the right
    field[:, :, :7, 1] = -2.0  # and the left one up
    with torch.no_grad():
        mask = torch.full((1, 14, 14), 0.25)
        geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), field, mask)
    token = torch.zeros(1, 4)
    clip = Encoded(recording(), Perception(token, geometry, token, (View(),), None), {})
    regions = evidence(clip)["regions"]
    assert tuple(regions) == REGIONS
    means = {name: (one["shear_change_x"], one["shear_change_y"]) for name, one in regions.items()}
    assert means == {
        "upper": pytest.approx((1.0, -1.0)),
        "lower": pytest.approx((0.0, -1.0)),
        "upper_minus_lower": pytest.approx((1.0, 0.0)),
        "left": pytest.approx((0.5, -2.0)),
        "right": pytest.approx((0.5, 0.0)),
        "left_minus_right": pytest.approx((0.0, -2.0)),
        "global": pytest.approx((0.5, -1.0)),
    }
    assert {one["contact_mass"] for one in regions.values()} == {0.25}


def told_of_file(answerer, clip, **options):
    encoded = answerer.encode(clip, **options)
    return [answerer.ask(encoded, f"file {topic}").text for topic in ("frames", "duration")]


def test_the_file_is_told_as_long_as_it_is_however_few_frames_were_looked_at():
    answerer = feeling(tiny_bundle(), "left")
    assert told_of_file(answerer, recording(2, fps=25.0)) == ["2 frames.", "0.08 s."]
    hundred = recording(100, fps=25.0)
    assert told_of_file(answerer, hundred, span=(24, 26)) == ["100 frames.", "4 s."]
    read = replace(hundred.select([0, 30, 60, 90]), recorded_frames=100)  # as of a long file
    assert told_of_file(answerer, read) == ["100 frames.", "4 s."]


def test_what_was_read_at_a_stride_knows_how_many_frames_there_were(tmp_path, monkeypatch):
    monkeypatch.setattr("geotlm_lm.recordings.policy.stride_for", lambda *given: 3)
    np.save(tmp_path / "long.npy", recording(11).frames)
    clip = read_clip(tmp_path / "long.npy")
    assert (clip.frame_numbers, clip.recorded_frames) == ((0, 3, 6, 9), 11)


def test_uneven_times_tell_how_long_it_is():
    clip = replace(recording(3, fps=10.0), times_s=(0.0, 0.1, 0.9))
    assert clip.recorded_s == pytest.approx(1.0)
