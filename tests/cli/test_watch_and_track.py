"""`watch` and `track` tell the same of the same recording, with the shipped model."""

import json
from pathlib import Path

import pytest

from tests.cli.running import run

RECORDINGS = Path(__file__).parents[2] / "app" / "recordings"


@pytest.mark.parametrize("name", ["key.mov", "hex_nut.mov"])
def test_watch_prints_the_events_of_track_by_when_they_end(capsys, name):
    code, out, notes = run(capsys, "track", RECORDINGS / name, "--json")
    tracked = json.loads(out)
    watch_code, out, _ = run(capsys, "watch", RECORDINGS / name, "--json")
    *events, account = map(json.loads, out.splitlines())
    assert (code, watch_code) == (0, 0)
    ends = [event["end_s"] for event in events]
    assert ends == sorted(ends)
    for event in events:
        assert event.pop("type") == "event"
    assert sorted(events, key=str) == sorted(tracked["events"], key=str)
    assert account["totals"] == tracked["totals"]
    assert "note" not in notes  # nothing about it was guessed
