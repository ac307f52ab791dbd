"""A scene on the grid: what is left out, what is dragged along, what a bad residual leads to."""

import math
from dataclasses import replace

import pytest
import torch

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation import contact
from geotlm_lm.simulation.contact import FAST, PRESETS, Preset, solve_contact
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Path, Scene
from geotlm_lm.simulation.solvers import Effort, march


def scene(body="letter_l", *, depth=(0.5, 0.5), x=(0, 0), y=(0, 0), turn=(0.3, 0.3), gel=None):
    path = Path(depth, x, y, turn)
    return Scene(Body(body, variant=2), path, Motion.STILL, gel or Gel(poisson_ratio=0.48))


def solved(pressed, preset=FAST, **options):
    return solve_contact(pressed, build_profile(pressed.body), preset, **options)


def test_friction_holds_the_gel_that_a_press_would_spread():
    gel = {"poisson_ratio": 0.48}
    middle = slice(FAST.cells // 2 - 5, FAST.cells // 2 + 5)
    free, held = (
        float(
            solved(scene("block", gel=Gel(friction=mu, **gel)), with_drift=True)
            .drift_mm[1, :, middle, middle]
            .norm()
        )
        for mu in (0.0, 1.0)
    )
    assert held < 0.5 * free


def test_a_press_does_not_depend_on_a_travel_of_nanometres():
    still, moved = (
        solved(scene("block", x=(0, x)), with_drift=True).drift_mm[1] for x in (0.0, 2e-9)
    )
    assert float((still - moved).abs().max()) < 1e-5


def test_little_friction_is_solved_and_not_skipped():
    slid = scene(x=(0, 0.3), gel=Gel(friction=0.02))
    quick, tight = (solved(slid, PRESETS[name], with_drift=True) for name in ("good", "accurate"))
    free = solved(scene(x=(0.3, 0.3), gel=Gel(friction=0.0)), with_drift=True)
    assert float((quick.drift_mm[1] - quick.drift_mm[0]).abs().max()) == pytest.approx(
        float((tight.drift_mm[1] - tight.drift_mm[0]).abs().max()), rel=0.3
    )
    assert free.status.is_converged


@pytest.mark.parametrize("preset", ["draft", "good"])
def test_friction_carries_the_surface_along_inside_its_cone(preset, monkeypatch):
    steps = []
    monkeypatch.setattr(contact, "march", lambda *a, **k: steps.extend(march(*a, **k)) or steps)
    answer = solved(scene(x=(0, 0.2)), PRESETS[preset], with_drift=True)
    status = answer.status
    assert status.is_converged
    assert status.preset == preset
    assert float(steps[-1].traction.abs().max()) > 0
    assert status.cone_excess < 1e-5
    work = torch.cat([step.work for step in steps])
    # What is not stored is rubbed away; below 0 by the time steps' error alone.
    assert work.sum() - steps[-1].energy > -0.02 * work.clamp_min(0).sum()
    moved = (answer.drift_mm[1] - answer.drift_mm[0])[0]
    assert 0.15 < float(moved.max()) < 0.21
    # The layer is dragged along around the contact and stands still far away.
    assert abs(float(moved[:, :2].mean())) < 0.02


def starved(name, harder):
    """Return a preset that has no steps to spend, in front of `harder`."""

    class Starved(Preset):
        @property
        def harder(self):
            return harder

    return Starved(name, 32, Effort((1,), friction_iterations=1, passes=1, most_passes=1))


def test_a_bad_residual_is_answered_by_the_next_preset_which_is_named():
    hard = scene("letter_l", depth=(2.5, 2.5), gel=Gel(thickness_mm=0.5, poisson_ratio=0.5))
    answer = solved(hard, starved("draft", PRESETS["good"]))
    assert answer.status.is_converged
    assert answer.status.preset == "good"
    assert answer.indentation_mm.shape[-1] == PRESETS["good"].cells


def test_running_out_of_steps_is_never_called_converged():
    hard = scene("letter_l", depth=(2.5, 2.5), gel=Gel(thickness_mm=0.5, poisson_ratio=0.5))
    status = solved(hard, starved("draft", None)).status
    assert not status.is_converged
    assert status.penetration_um > 30
    slid = replace(hard, path=replace(hard.path, x_mm=(0.0, 0.2)))
    assert not solved(slid, starved("draft", None), with_drift=True).status.is_converged


@pytest.mark.parametrize(("thickness", "is_enough"), [(4.0, True), (0.3, False)])
def test_where_the_gel_bulges_high_the_whole_body_is_looked_at(thickness, is_enough, monkeypatch):
    key = scene("key", depth=(1.2,), x=(0,), y=(0,), turn=(0,))
    key = replace(key, gel=Gel(thickness_mm=thickness, poisson_ratio=0.5))
    part = solved(key)
    monkeypatch.setattr(contact, "LEAST_REACH_MM", math.inf)
    whole = solved(key)
    assert float((part.indentation_mm - whole.indentation_mm).abs().max()) < 0.001
    assert (part.reach_mm < math.inf) == is_enough


def test_a_gel_sheared_before_the_clip_is_sheared_from_its_first_frame_on_by_friction_alone():
    handled, rest = (
        Scene(
            Body("block"),
            Path((0.5, 0.5), (0.0, 0.0), (0.0, 0.0), (0.3, 0.3), pre_slide_mm=(slide_mm, 0.0)),
            Motion.STILL,
            Gel(friction=50.0),
        )
        for slide_mm in (0.2, 0.0)
    )
    sheared, plain = (solved(case, with_drift=True) for case in (handled, rest))
    pressed = sheared.indentation_mm[0] > 0.8 * sheared.indentation_mm[0].max()
    gained = (sheared.drift_mm - plain.drift_mm)[:, 0, pressed]
    # So much friction holds the gel on the object: it has come along by the object's travel.
    assert gained.mean(dim=1).numpy() == pytest.approx([0.2, 0.2], abs=0.02)
    assert torch.equal(solved(handled).indentation_mm, solved(rest).indentation_mm)
