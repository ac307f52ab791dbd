"""People who see little, or use keys alone, can use the page: axe finds nothing serious."""

import json
from pathlib import Path

import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")
axe_core_python = pytest.importorskip("axe_core_python", reason="axe is in the extra dev")

from tests.app.browser import STAGE  # noqa: E402

pytestmark = pytest.mark.slow

TABS = ("Ask", "Compare", "Live", "Simulate")
RUN = """;window.found = null; axe.run(document, {resultTypes: ['violations']}).then(told => {
    window.found = JSON.stringify(told.violations.map(
        one => [one.impact, one.id, one.nodes.map(node => node.html.slice(0, 200))]))}); 1"""


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_critical_or_serious(empty, address, theme):
    browser = opened(empty, address, theme)
    for tab in TABS:
        browser.click(tab, "button[role=tab]")
        browser.wait_for(
            f"document.querySelector('button[role=tab][aria-selected=true]').innerText == {tab!r}"
        )
        assert found_by_axe(browser) == [], tab


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_nor_while_a_recording_is_watched_and_asked_about(empty, address, theme, long_recording):
    browser = opened(empty, address, theme)
    browser.click("Live", "button[role=tab]")
    browser.upload("Recording", long_recording)
    browser.wait_for("document.body.innerText.includes('long')")
    browser.click("Watch", "button.primary")
    browser.click("When did it stop?", ".chips button")
    browser.wait_for("document.body.innerText.includes('neither turns nor slides')")
    assert found_by_axe(browser) == []
    assert browser.run(f"!{STAGE}.querySelector('[data-part=live]').hidden"), "it was over"


def opened(empty, address, theme):
    empty.open(f"{address}?__theme={theme}")
    return empty


def found_by_axe(browser):
    """Return what is critical or serious of what is seen."""
    axe = (Path(axe_core_python.__file__).parent / "axe.min.js").read_text()
    browser.run(axe + RUN)
    browser.wait_for("window.found !== null")
    found = json.loads(browser.run("window.found"))
    return [one for one in found if one[0] in ("critical", "serious")]
