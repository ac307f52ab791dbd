"""What was found is saved by the browser: the track, the conversation, a link to both."""

import base64
import csv
import io
import json
from urllib.parse import parse_qs

import pytest
from app.clip_loading import perceive
from app.saving import offered, saved

from geotlm_lm import GeoTLMError
from tests.app.fakes import FakeAnswerer
from tests.app.test_stage import clip_of, tracked  # noqa: F401


def content(file):
    return base64.b64decode(file["content"])


@pytest.fixture
def talked():
    answerer = FakeAnswerer()
    answerer.bundle.reader.lines["Which & way?"] = "way"
    shown = perceive(answerer, clip_of(4))
    shown.session.ask("Which & way?")
    return shown


def test_only_what_there_is_can_be_saved(tracked, talked):  # noqa: F811
    assert offered(None, None) == {"kinds": []}
    assert offered(tracked, None)["kinds"] == ["track.csv", "track.json", "track.png"]
    assert offered(talked, "cap")["kinds"] == ["talk.txt", "talk.json", "link"]
    with pytest.raises(GeoTLMError, match="^There is nothing of this kind to save; open a"):
        saved("track.csv", talked, "cap", None)


def test_the_track_is_saved_frame_by_frame(tracked):  # noqa: F811
    file = saved("track.csv", tracked, "my key.npz", None)
    assert (file["name"], file["mime"]) == ("my_key_track.csv", "text/csv")
    rows = list(csv.DictReader(io.StringIO(content(file).decode())))
    assert len(rows) == 40
    assert float(rows[25]["time_s"]) == 1.0
    told = json.loads(content(saved("track.json", tracked, "my key.npz", None)))
    assert told["made_by"]["recording"] == "my key.npz"
    assert len(told["events"]) == len(tracked.encoded.track.events)


def test_the_timeline_is_saved_as_a_picture(tracked):  # noqa: F811
    pytest.importorskip("matplotlib", reason="the plot needs matplotlib (extra: track)")
    assert content(saved("track.png", tracked, "key", None)).startswith(b"\x89PNG")


def test_the_conversation_is_saved_in_words_and_whole(talked):
    (turn,) = json.loads(content(saved("talk.json", talked, "cap", None)))
    assert turn["question"] == "Which & way?"
    said = content(saved("talk.txt", talked, "cap", None)).decode()
    assert said == f"Which & way?\n{turn['answer']['text']}\n"


def test_a_link_names_the_example_and_the_last_question(talked):
    link = saved("link", talked, "cap", "bottle_cap")["link"]
    assert parse_qs(link.removeprefix("?")) == {"example": ["bottle_cap"], "q": ["Which & way?"]}
