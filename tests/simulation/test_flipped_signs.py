"""Tests of the tests: each sign or constant that is flipped on purpose must fail one of them."""

import importlib
import inspect
import types

import pytest

from tests.simulation import contact_problems
from tests.simulation import test_closed_forms as closed
from tests.simulation import test_elastic as elastic
from tests.simulation import test_solvers as solvers

FORM = "test_every_closed_form_is_met_at_each_size_and_at_its_order"
TWIST = "test_a_twist_clockwise_takes_the_top_to_the_right_and_the_right_down"
SLID = ("ball slid and back, Mindlin and Deresiewicz", "drag")
FLIPS = [
    ("elastic", "3.0 - 4.0 * poisson_ratio", "3.0 + 4.0 * poisson_ratio", elastic,
     "test_the_closed_form_solves_the_boundary_value_problem", (0.4, 0.3)),
    ("elastic", "-torch.fft.rfft2(pressure)[:, None]", "torch.fft.rfft2(pressure)[:, None]",
     elastic, "test_what_drag_lifts_pressure_spreads", (elastic.operator,)),
    ("elastic", "(1 - nu) * whole + nu * along_x", "(1 - nu) * whole - nu * along_x", elastic,
     "test_far_from_a_load_only_its_force_counts", ()),
    ("solvers", "arm[:, 0] - sin * arm[:, 1]", "arm[:, 0] + sin * arm[:, 1]", solvers, TWIST, ()),
    ("solvers", "target = last.drift_mm + travel_mm", "target = travel_mm", closed, FORM, SLID),
]  # fmt: skip


@pytest.mark.parametrize(("room", "old", "new", "tests", "test", "given"), FLIPS)
def test_a_flipped_sign_or_constant_fails_its_test(monkeypatch, room, old, new, tests, test, given):
    getattr(tests, test)(*given)  # it passes as the source stands
    original = importlib.import_module(f"geotlm_lm.simulation.{room}")
    source = inspect.getsource(original)
    assert source.count(old) == 1, f"{room} no longer reads {old!r}"
    changed = types.ModuleType(original.__name__)
    exec(compile(source.replace(old, new), original.__file__, "exec"), changed.__dict__)
    closed.solutions.cache_clear()
    for name, value in vars(changed).items():
        for user in (tests, contact_problems):
            if not name.startswith("__") and hasattr(user, name):
                monkeypatch.setattr(user, name, value)
    with pytest.raises(AssertionError):
        getattr(tests, test)(*given)
    closed.solutions.cache_clear()
