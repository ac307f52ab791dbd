"""A tool's parameters are checked once, whoever calls it; what fails in it is told as our fault."""

import pytest

from app import parameters as p
from app.api import Api
from app.tools import OUR_FAULT, Tool
from geotlm_lm import GeoTLMError
from geotlm_lm.simulation.touch import RANGES


def double(number: p.bounded(0.0, 2.0, "A number.") = 1.0) -> dict[str, float]:
    """Return twice a number."""
    return {"double": 2 * number}


def broken() -> dict[str, float]:
    """Fail."""
    raise ZeroDivisionError("a secret of the server")


def test_a_tool_says_what_it_takes_and_gives():
    tool = Tool.of(double)
    assert tool.input_schema == {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "number": {
                "type": "number",
                "minimum": 0.0,
                "maximum": 2.0,
                "default": 1.0,
                "description": "A number.",
            }
        },
    }
    assert tool.output_schema == {"type": "object", "additionalProperties": {"type": "number"}}
    assert (tool.name, tool.description) == ("double", "Return twice a number.")
    assert tool.call({"number": 0.5}) == {"double": 1.0}


def test_a_number_out_of_bounds_is_told_with_what_it_may_be():
    with pytest.raises(GeoTLMError) as caught:
        Tool.of(double).call({"number": 3})
    assert str(caught.value) == (
        "double: number was 3, and input should be less than or equal to 2; the tool's schema says "
        "what it may be."
    )


def test_a_mistake_of_ours_is_logged_and_its_words_are_not_told(caplog):
    with pytest.raises(GeoTLMError) as caught:
        Tool.of(broken).call({})
    assert str(caught.value) == OUR_FAULT
    assert "a secret of the server" in caplog.text


def test_a_simulated_touch_has_the_bounds_of_the_simulator():
    tools = [Tool.of(function) for function in Api(None, None).functions]
    (simulate,) = (tool for tool in tools if tool.name == "simulate")
    offered = simulate.input_schema["properties"]
    numbers = {name: one for name, one in offered.items() if "minimum" in one}
    assert len(numbers) == 7
    for name, one in numbers.items():
        assert (one["minimum"], one["maximum"]) == RANGES[name]
