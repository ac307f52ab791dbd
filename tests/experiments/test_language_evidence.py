"""Stated evidence against fields whose signs are known."""

from types import SimpleNamespace

import pytest

from geotlm_lm.conversation.reasons import halves
from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.experiments.language_evidence import CLAIMS_OF, claims_right, stated_claims


def regions(**components):
    """Regions whose shear change is 0 but for `region_axis=value`."""
    values = {
        name: {"shear_change_x": 0.0, "shear_change_y": 0.0, "contact_mass": 0.5}
        for name in REGIONS
    }
    for key, value in components.items():
        region, axis = key.rsplit("_", 1)
        values[region][f"shear_change_{axis}"] = value
    return values


CLOCKWISE = regions(upper_minus_lower_x=2.0, left_minus_right_y=-2.0)


def by_rule(field):
    return SimpleNamespace(told_by="rule", text=halves(field), direction=None)


def test_words_by_rule_claim_what_the_halves_do():
    assert stated_claims(by_rule(CLOCKWISE)) == [
        ("upper_minus_lower", "right"),
        ("left_minus_right", "up"),
    ]


def test_words_agree_with_the_field_they_were_read_from():
    assert claims_right(by_rule(CLOCKWISE), CLOCKWISE) == [True, True]


def test_every_sign_turned_round_disagrees():
    turned = regions(upper_minus_lower_x=-2.0, left_minus_right_y=2.0)
    assert claims_right(by_rule(CLOCKWISE), turned) == [False, False]


def test_a_common_shift_is_a_claim_about_the_whole():
    field = regions(global_y=-1.0)
    assert stated_claims(by_rule(field)) == [("global", "up")]
    assert claims_right(by_rule(field), regions(global_y=0.5)) == [False]


@pytest.mark.parametrize("motion", DIRECTED)
def test_the_models_own_sentence_claims_the_sign_of_its_motion(motion):
    answer = SimpleNamespace(told_by="model", text="", direction=motion)
    assert stated_claims(answer) == list(CLAIMS_OF[motion])


def test_the_model_claims_nothing_of_a_press():
    answer = SimpleNamespace(told_by="model", text="", direction=Motion.PRESS)
    assert stated_claims(answer) == []
