"""Other number formats: they answer, leave the bundle alone, and are told apart by their digest."""

from dataclasses import astuple, replace

import numpy as np
import pytest

from geotlm_lm import precision as formats
from geotlm_lm import read_clip
from geotlm_lm.answering import Answerer
from geotlm_lm.backbone.vit import FrozenBackbone
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import resource_dir
from geotlm_lm.core.number_formats import OFFERED
from geotlm_lm.precision import PRECISIONS, in_offered_format, in_precision
from tests.answering.scripted import ScriptedReader, recording


@pytest.mark.parametrize("precision", PRECISIONS)
def test_every_format_answers_and_leaves_the_bundle_alone(bundle, precision):
    bundle = replace(bundle, reader=ScriptedReader())
    before = bundle.digest()
    changed = Answerer(in_precision(bundle, precision))
    encoded, exact = changed.encode(recording()), Answerer(bundle).encode(recording())
    answer = changed.ask(encoded, "Is it turning clockwise?")
    assert sum(answer.options.values()) == pytest.approx(1.0, abs=1e-3)
    moved, expected = (astuple(one.belief.mean) for one in (encoded, exact))
    assert moved == pytest.approx(expected, abs=0.02)
    assert encoded.belief.ways == pytest.approx(exact.belief.ways, abs=0.02)
    assert bundle.digest() == before


def test_an_unknown_format_is_refused(bundle):
    with pytest.raises(ValueError, match="found float8 of"):
        in_precision(bundle, "float8")
    with pytest.raises(UsageError, match="found precision 'float8', expected one of float32,"):
        in_offered_format(bundle, "float8")


def test_float32_is_the_bundle_itself_and_every_format_has_a_digest_of_its_own(bundle):
    assert in_offered_format(bundle, "float32") is bundle
    assert len({in_offered_format(bundle, precision).digest() for precision in OFFERED}) == len(
        OFFERED
    )


@pytest.mark.parametrize("fails", ["made", "run"])
def test_what_the_machine_cannot_make_or_run_is_told_in_a_sentence(bundle, monkeypatch, fails):
    def refuse(*_):
        raise RuntimeError("Didn't find engine for operation quantized::linear_prepack NoQEngine")

    monkeypatch.setattr(
        *((formats, "_quantised") if fails == "made" else (FrozenBackbone, "encode_inputs")), refuse
    )
    with pytest.raises(UsageError, match="cannot run int8; take float32"):
        in_offered_format(bundle, "int8")


@pytest.mark.parametrize("precision", OFFERED)
def test_what_is_drawn_and_graded_stays_in_float32(bundle, precision):
    answerer = Answerer(in_offered_format(bundle, precision))
    geometry = answerer.encode(recording()).perception.geometry
    assert geometry.shear_change.numpy().dtype == geometry.mask.numpy().dtype == np.float32


def test_the_shipped_model_in_eight_bits_says_what_it_says_in_float32():
    exact, coarse = (Answerer.load(precision=one) for one in ("float32", "int8"))
    question = "Which way is it turning?"
    clip = read_clip(resource_dir("app") / "examples" / "bottle_cap_clockwise.npz")
    first, second = (one.ask(one.encode(clip), question) for one in (exact, coarse))
    assert first.direction == second.direction == "clockwise"
    assert second.confidence == pytest.approx(first.confidence, abs=0.15)
