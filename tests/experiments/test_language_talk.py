"""The whole evaluation on a few simulated clips, with weights drawn at random."""

import json
from dataclasses import asdict

import numpy as np
import pytest
import torch

from geotlm_lm.answering import Answerer
from geotlm_lm.core.labels import Motion
from geotlm_lm.data.templates import load_templates
from geotlm_lm.experiments.language_cases import blind, mirrored, simulated_touches
from geotlm_lm.experiments.language_talk import evaluate_talk
from geotlm_lm.reports.language import language_headline, language_page
from tests.answering.scripted import recording
from tests.tiny_bundle import tiny_bundle


@pytest.fixture(scope="module")
def answerer():
    return Answerer(tiny_bundle())


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def record(answerer, told, tmp_path_factory):
    folder = tmp_path_factory.mktemp("labelled")
    (folder / "clips").mkdir()
    np.save(folder / "clips" / "cap.npy", recording(frames=9).frames)
    (folder / "windows.csv").write_text(
        "clip,first_frame,last_frame,direction\ncap.npy,1,8,clockwise\n"
    )
    return evaluate_talk(
        answerer,
        clips=2,
        seed=3,
        real_folder=folder,
        windows=4,
        progress=lambda *at: told.append(at),
    )


def test_simulated_and_real_clips_are_never_pooled(record):
    (simulated, real) = record.numbers["sets"]
    assert simulated == "simulated"
    assert real.startswith("real labelled")
    assert [one["clips"] for one in record.numbers["sets"].values()] == [2, 2]


def test_every_type_is_asked_about_and_amounts_only_where_they_are_known(record):
    simulated, real = record.numbers["sets"].values()
    every = set(load_templates().types)
    assert set(simulated["types"]) >= every - {"T10"}  # evidence of a press is not judged
    assert set(real["types"]) == every - {"T7", "T8"}


def test_words_that_no_weight_was_trained_for_are_wrong_not_left_out(record):
    opened = record.numbers["sets"]["simulated"]["types"]["T1"]
    assert opened["questions"] == 2
    assert opened["methods"]["words"]["accuracy"] == 0.0
    assert opened["faults"] == {"no words": 2}


def test_the_record_is_json_and_makes_a_page(record):
    page = language_page(type(record)(**json.loads(json.dumps(asdict(record)))))
    assert "## simulated" in page
    assert "2 no words" in page
    assert "| claim and its denial " in page


def test_the_headline_has_a_row_for_every_pool_of_types(record):
    pools = [[*own["pooled"]] for own in record.numbers["sets"].values()]
    table = language_headline(record).split("\n\n")[0].splitlines()
    assert [line.split("|")[2].strip() for line in table[2:]] == sum(pools, [])
    assert len({line.count("|") for line in table}) == 1


def test_progress_reaches_its_ends(record, told):
    assert ("simulated, perceived", 2, 2) in told
    assert told[-1][1] == told[-1][2]


@pytest.fixture(scope="module")
def touches(answerer):
    return list(simulated_touches(answerer, 3, 1, lambda done, total: None))


def test_the_true_field_goes_the_way_of_a_slide(touches, answerer):
    ways = {Motion.LEFT: -1, Motion.RIGHT: 1}
    found = 0
    for seed in range(4):
        for one in simulated_touches(answerer, 6, seed, lambda done, total: None):
            if one.motion in ways:
                found += 1
                assert ways[one.motion] * one.field["global"]["shear_change_x"] > 0
    assert found >= 2


def test_a_blind_view_is_the_mean_and_the_same_for_every_clip(touches):
    nobody = blind(touches)
    tokens = torch.stack([one.encoded.perception.fused_token for one in touches])
    assert torch.allclose(nobody.perception.fused_token, tokens.mean(0))
    mass = torch.stack([one.encoded.perception.geometry.region_mass for one in touches])
    assert torch.allclose(nobody.perception.geometry.region_mass, mass.mean(0))


def test_a_mirrored_clip_is_the_clip_when_mirrored_again():
    clip = recording()
    twice = mirrored(mirrored(clip))
    assert np.array_equal(twice.frames, clip.frames)
    assert np.array_equal(twice.background, clip.background)
    assert not np.array_equal(mirrored(clip).frames, clip.frames)
