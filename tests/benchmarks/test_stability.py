"""What is done to clips is what the table says, and whatever comes of it becomes a row."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from geotlm_lm.benchmarks import stability
from geotlm_lm.benchmarks.damaged import damage_kinds, extreme_clips
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.benchmarks.stability import (
    MASKS,
    STIFF_CASES,
    Verdict,
    contact_row,
    failures_headline,
    judge,
    judge_scene,
    mask_row,
    row_of,
)
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import GeoTLMError, UnreadableClip
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.encoder import DGR

SIDE = 64


class Saying:
    """Answers every clip alike."""

    def __init__(self, motion=Motion.RIGHT, confidence=0.95, abstained=False, error=None):
        told = {"direction": motion, "confidence": confidence, "abstained": abstained}
        self.answer, self.error, self.clips = SimpleNamespace(text="Right.", **told), error, []

    def encode(self, clip):
        self.clips.append(clip)
        if self.error:
            raise self.error
        return clip

    def ask(self, encoded, question):
        return self.answer


def touched():
    """A square imprint left of the middle that travels to the right over a flat gel."""
    idle = np.full((SIDE, SIDE, 3), 100, np.uint8)
    frames = np.repeat(idle[None], 4, axis=0)
    for number in range(4):
        frames[number, 28:36, 8 + 2 * number : 16 + 2 * number] = 140
    return Clip(frames, background=idle, name="touch")


ENDS = [
    (Saying(Motion.RIGHT), "right", "Right."),
    (Saying(Motion.LEFT), "wrong", "Right."),
    (Saying(None, 0.0, abstained=True), "abstained", "Right."),
    (Saying(error=UnreadableClip("touch: is black")), "refused", "touch: is black"),
    (Saying(error=KeyError("token")), "crashed", "KeyError: 'token'"),
]


@pytest.mark.parametrize(("answerer", "outcome", "says"), ENDS)
def test_every_end_of_a_question_has_its_name(answerer, outcome, says):
    verdict = judge(answerer, touched, {Motion.RIGHT})
    assert (verdict.outcome, verdict.text) == (outcome, says)


def test_a_row_counts_outcomes_and_quotes_the_gravest():
    wrong = {Motion.LEFT: 0.95, Motion.STILL: 0.5, Motion.UP: 0.75, Motion.NONE: 0.9}
    verdicts = [Verdict("right", 0.8, "yes"), Verdict("refused", 0.0, "black")]
    verdicts += [Verdict("wrong", sure, f"{motion}", motion) for motion, sure in wrong.items()]
    row = row_of("noise", verdicts)
    assert [row.detail[name] for name in ("right", "wrong", "refused", "crashed")] == [1, 4, 1, 0]
    assert row.interval[0] < row.error == 0.8 < row.interval[1]
    assert row.detail["probability"] == pytest.approx(0.78)
    assert row.detail["false_directions"] == 2
    assert row.detail["confident_false_directions"] == row.detail["confident_oversights"] == 1
    assert row.outcome == str(Motion.LEFT)


def test_damage_is_asked_about_level_by_level(monkeypatch):
    kinds = {name: damage_kinds()[name] for name in ("as recorded", "frames dropped")}
    case = Case(touched(), Motion.RIGHT, "block")
    monkeypatch.setattr(stability, "damage_kinds", lambda: kinds)
    monkeypatch.setattr(stability, "first_cases", lambda *size: [case, case])
    answerer = Saying(Motion.RIGHT)
    rows = list(stability.damage_rows(Run(answerer_given=answerer)))
    assert [len(clip) for clip in answerer.clips] == [4, 4, 3, 3, 2, 2, 1, 1]
    assert answerer.clips[4].frame_numbers == (0, 3)  # as far as the whole clip
    told = [(row.variant, row.count) for row in rows]
    assert told == [("-", 2), ("1 of 4", 2), ("2 of 4", 2), ("3 of 4", 2)]


def test_every_extreme_recording_is_made_or_refused_in_a_sentence():
    refused = set()
    for name, extreme in extreme_clips(touched(), Motion.RIGHT, long_frames=400).items():
        try:
            extreme.make()
        except GeoTLMError:
            refused.add(name)
    assert refused == {"7x7 pixels", "background of another size"}


def test_stiff_scenes_are_simulated_and_asked_about_or_refused():
    ends = {"friction 0": "right", "depth -0.5 mm": "wrong", "depth NaN": "refused"}
    run = Run(answerer_given=Saying(Motion.CLOCKWISE))
    assert {name: judge_scene(run, STIFF_CASES[name]).outcome for name in ends} == ends


@pytest.mark.parametrize("name", ["key, 9 degree turn", "depth -0.5 mm"])
def test_a_scene_is_solved_with_a_small_residual(name):
    row = contact_row(name, STIFF_CASES[name])
    assert row.outcome == "solved"
    assert 0 <= row.detail["penetration_um"] < 100


LEFT = Verdict("wrong", 0.96, "Left.", motion=Motion.LEFT)
ROWS = [
    row_of("small", [Verdict("right", 0.9, "yes")] * 4, "56 px"),
    row_of("small", [Verdict("right", 0.6, "yes")] * 3 + [LEFT], "8 px"),
    row_of("friction 1e6", [Verdict("crashed", 0.0, "KeyError: 1")]),
]


def test_the_headline_names_crashes_and_confident_mistakes():
    assert failures_headline(ROWS).splitlines() == [
        "- crashed: friction 1e6, words 1/1",
        "- a wrong direction at 0.9 or more: small, 8 px 1/4",
        "- a touch or motion overlooked at 0.9 or more: none",
    ]


def test_the_floor_shrinks_as_its_closed_form_says_and_gradients_stay_bounded():
    rows = {mask: mask_row(mask).detail for mask in MASKS}
    for mask, row in rows.items():
        # 196 cells of the mask over themselves and the floor.
        assert row["pooled"] == pytest.approx(196 * mask / (196 * mask + 1e-6), rel=1e-5)
        assert row["recovered"] == pytest.approx(1.0, rel=1e-5)
        assert row["its_mass"] == 0
    assert rows[1.0]["empty_half"] == pytest.approx(-1.0, rel=1e-5)
    first, second, last = (rows[MASKS[power]] for power in (3, 4, 12))
    assert last["by_logit"] < 1e-3 * first["by_logit"]  # 98e-12 against a floor of 1e-6
    # By the mask itself it grows tenfold a decade until the floor holds it.
    assert second["by_mask"] / first["by_mask"] == pytest.approx(10, rel=0.2)


@pytest.mark.parametrize("mask", [1e-3, 1e-12])
def test_the_gradient_of_dgr_agrees_with_central_differences_under_faint_contact(mask):
    generator = torch.Generator().manual_seed(0)
    dgr = DGR(6).double()
    with torch.no_grad():
        for parameter in dgr.parameters():
            parameter.normal_(0.0, 0.5, generator=generator)
        # Noise on the mask's logit, so that the cells differ; its middle gives `mask`.
        dgr.to_mask.weight.mul_(0.1)
        dgr.to_mask.bias.fill_(float(torch.logit(torch.tensor(mask, dtype=torch.float64))))
    patches = torch.randn((1, 2, 4, 4, 6), generator=generator, dtype=torch.float64)
    patches.requires_grad_(True)
    assert torch.autograd.gradcheck(lambda tokens: dgr(tokens).feature, patches)
