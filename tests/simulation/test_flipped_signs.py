"""Tests of the tests: each sign or constant that is flipped on purpose must fail one of them."""

import importlib
import inspect
import types

import pytest

from tests.simulation import (
    contact_problems,
    test_closed_forms,
    test_elastic,
    test_friction,
    test_half_space,
    test_march,
)

FLIPS = {
    "bonded layer: kappa = 3 + 4 nu": (
        "elastic",
        ("3.0 - 4.0 * poisson_ratio", "3.0 + 4.0 * poisson_ratio"),
        (test_elastic, "test_the_closed_form_solves_the_boundary_value_problem", (0.4, 0.3)),
    ),
    "bonded layer: normal response with the shear's sign": (
        "elastic",
        ("(2 * kappa * sinh - 8 * x * small)", "(2 * kappa * sinh + 8 * x * small)"),
        (test_elastic, "test_the_closed_form_solves_the_boundary_value_problem", (0.4, 0.3)),
    ),
    "bonded layer: pressure spreads the wrong way": (
        "elastic",
        ("-torch.fft.rfft2(pressure)[:, None]", "torch.fft.rfft2(pressure)[:, None]"),
        (test_elastic, "test_what_drag_lifts_pressure_spreads", (24,)),
    ),
    "half-space: Cerruti's nu with the wrong sign": (
        "half_space",
        ("(1 - nu) * whole + nu * along_x", "(1 - nu) * whole - nu * along_x"),
        (test_half_space, "test_far_from_a_load_only_its_force_counts", ()),
    ),
    "half-space: two pi for four pi": (
        "half_space",
        ("(1 - 2 * nu) * slope_x / (4 * np.pi)", "(1 - 2 * nu) * slope_x / (2 * np.pi)"),
        (test_half_space, "test_far_from_a_load_only_its_force_counts", ()),
    ),
    "friction: discs twice as wide": (
        "friction",
        ("torch.where(length > limit, limit /", "torch.where(length > 2 * limit, 2 * limit /"),
        (test_friction, "test_full_sliding_drags_with_all_friction_there_is", ()),
    ),
    "friction: traction against the slip's sense": (
        "friction",
        ("response.shear(traction) - target_mm", "response.shear(traction) + target_mm"),
        (test_friction, "test_under_huge_friction_everything_sticks", ()),
    ),
    "march: a turn the other way round": (
        "march",
        ("(cos - 1) * arm[:, 0] - sin * arm[:, 1]", "(cos - 1) * arm[:, 0] + sin * arm[:, 1]"),
        (test_march, "test_a_twist_clockwise_takes_the_top_to_the_right_and_the_right_down", ()),
    ),
    "march: history forgotten": (
        "march",
        ("target = last.drift_mm + increment", "target = increment"),
        (
            test_closed_forms,
            "test_every_closed_form_is_met_at_each_size_and_at_its_order",
            ("ball slid and back, Mindlin and Deresiewicz", "drag"),
        ),
    ),
}


def with_source_changed(module_name, old, new):
    """Return a copy of a module of the simulator whose source reads `new` for `old`."""
    original = importlib.import_module(f"geotlm_lm.simulation.{module_name}")
    source = inspect.getsource(original)
    assert source.count(old) == 1, f"{module_name} no longer reads {old!r}"
    changed = types.ModuleType(original.__name__)
    changed.__dict__["__file__"] = original.__file__
    exec(compile(source.replace(old, new), original.__file__, "exec"), changed.__dict__)
    return changed


@pytest.mark.parametrize("flip", FLIPS)
def test_a_flipped_sign_or_constant_fails_its_test(flip, monkeypatch):
    module_name, (old, new), (tests, test, arguments) = FLIPS[flip]
    getattr(tests, test)(*arguments)  # it passes as the source stands
    test_closed_forms.solutions.cache_clear()
    changed = with_source_changed(module_name, old, new)
    for name, value in vars(changed).items():
        for user in (tests, contact_problems):
            if not name.startswith("__") and hasattr(user, name):
                monkeypatch.setattr(user, name, value)
    with pytest.raises(AssertionError):
        getattr(tests, test)(*arguments)
    test_closed_forms.solutions.cache_clear()
