"""A session describes what was changed for it alone, and tells of all parts when asked."""

import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from gradio.state_holder import SessionState  # noqa: E402

from app import ui  # noqa: E402
from app.clip_loading import load_clip  # noqa: E402
from app.light_sessions import LightSession, LightSessions  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402


@pytest.fixture(scope="module")
def page():
    return ui.build(FakeAnswerer())


def test_a_session_shows_what_the_toolkits_own_does(page):
    light, own = LightSession(page), SessionState(page)
    assert light.config_values == {}
    assert list(light.components) == list(own.components)


def test_what_is_changed_for_one_visitor_is_not_for_another(page):
    page.state_session_capacity = 10
    sessions = LightSessions(page)
    key = next(one for one, block in page.blocks.items() if type(block).__name__ == "Textbox")
    sessions["one"]._update_value_in_config(key, "typed")
    values = {
        name: [
            part["props"].get("value") for part in sessions[name].components if part["id"] == key
        ]
        for name in ("one", "other")
    }
    assert values["one"] == ["typed"]
    assert values["other"] != ["typed"]
    assert list(sessions["one"].config_values) == [key]


def test_the_served_page_keeps_light_sessions(page):
    ui.launch(page)
    try:
        assert isinstance(page.app.state_holder["a visitor"], LightSession)
        assert page.state_holder is page.app.state_holder
    finally:
        page.close()


def test_what_the_visitor_has_open_who_was_away_longest_is_closed_first(page, recordings):
    page.state_session_capacity = 10
    sessions = LightSessions(page)
    shown = load_clip(FakeAnswerer(), str(recordings["dark"]))
    key = next(one for one, block in page.blocks.items() if type(block).__name__ == "State")
    for name in ("one", "other"):
        sessions[name][key] = shown
    sessions["one"]  # comes back
    assert sessions.let_go()
    assert [sessions[name][key] for name in ("one", "other")] == [shown, None]
    assert sessions.let_go()
    assert not sessions.let_go()
