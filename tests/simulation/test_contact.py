"""A scene on the grid: what is left out, what is dragged along, what a bad residual leads to."""

from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation import contact
from geotlm_lm.simulation.contact import BOX_MM, solve_contact
from geotlm_lm.simulation.march import Effort
from geotlm_lm.simulation.presets import FAST, PRESETS, Preset
from geotlm_lm.simulation.profile import build_profile
from geotlm_lm.simulation.scene import Body, Gel, Path, Scene


def scene(body="letter_l", *, depth=(0.5, 0.5), x=(0, 0), y=(0, 0), turn=(0.3, 0.3), gel=None):
    path = Path(depth, x, y, turn)
    return Scene(Body(body, variant=2), path, Motion.STILL, gel or Gel(poisson_ratio=0.48))


def solved(one, preset=FAST, **options):
    return solve_contact(one, build_profile(one.body), preset, **options)


def test_without_being_asked_nothing_tangential_is_solved():
    answer = solved(scene(x=(0, 0.4)))
    assert answer.drift_mm is None
    assert answer.status.friction_iterations == 0


def test_a_pure_press_needs_no_friction():
    answer = solved(scene(depth=(0.2, 0.6)), with_drift=True)
    assert answer.status.friction_iterations == 0
    assert answer.drift_mm.shape == (2, 2, FAST.cells, FAST.cells)


@pytest.mark.parametrize("preset", ["draft", "fast", "good"])
def test_friction_carries_the_surface_along_inside_its_cone(preset):
    answer = solved(scene(x=(0, 0.2)), PRESETS[preset], with_drift=True)
    status = answer.status
    assert status.is_converged
    assert status.preset == preset
    assert status.friction_iterations > 0
    assert status.cone_excess < 1e-5
    assert status.dissipated_share > -0.02
    moved = (answer.drift_mm[1] - answer.drift_mm[0])[0]
    assert 0.15 < float(moved.max()) < 0.21
    # The layer is dragged along around the contact and stands still far away.
    assert abs(float(moved[:, :2].mean())) < 0.02


def test_on_a_slippery_gel_nothing_is_carried_along():
    answer = solved(scene(x=(0, 0.2), gel=Gel(friction=0.0)), with_drift=True)
    spread = solved(scene(), with_drift=True)
    assert float((answer.drift_mm[0] - spread.drift_mm[0]).abs().max()) < 2e-3


def test_a_twist_clockwise_turns_the_gel_clockwise():
    answer = solved(scene("prism_6", turn=(0.0, 0.08)), with_drift=True)
    x, y = (answer.drift_mm[1] - answer.drift_mm[0]).numpy()
    axis = (np.arange(FAST.cells) - (FAST.cells - 1) / 2) * BOX_MM / FAST.cells
    across, along = np.meshgrid(axis, axis)
    near = np.hypot(across, along) < 4
    assert (x * -along)[near].mean() > 0
    assert (y * across)[near].mean() > 0


def test_finer_presets_come_closer_to_the_reference():
    one = scene("prism_6", turn=(0.0, 0.1))
    exact = solved(one, PRESETS["accurate"], with_drift=True)
    centre = exact.indentation_mm[1].max()
    errors = [
        abs(float(solved(one, PRESETS[name], with_drift=True).indentation_mm[1].max() - centre))
        for name in ("draft", "good")
    ]
    assert errors[1] < errors[0]


def starved(name, harder):
    """A preset that has no steps to spend, in front of `harder`."""

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


def test_large_steps_are_marched_in_small_ones(monkeypatch):
    counts = []
    real = contact.march

    def counting(increments, *args, **options):
        counts.append(len(increments))
        return real(increments, *args, **options)

    monkeypatch.setattr(contact, "march", counting)
    solved(scene(x=(0, 0.2)), with_drift=True)
    solved(scene(x=(0, 0.8)), with_drift=True)
    solved(scene(turn=(0.0, np.radians(9.5))), with_drift=True)
    assert counts == [2, 1 + 3, 1 + 4]


def test_a_gel_out_of_touch_is_at_rest():
    answer = solved(scene(depth=(-0.1, -0.2), x=(0, 1)), with_drift=True)
    assert not answer.indentation_mm.any()
    assert not answer.drift_mm.any()
    assert not answer.touches.any()
    assert answer.status.is_converged
