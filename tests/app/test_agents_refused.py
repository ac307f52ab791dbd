"""What agents must not: everything wrong is refused in one sentence, and leaves nothing behind."""

import pickle
import sys
import zipfile
from http.client import HTTPConnection
from urllib.parse import urlsplit

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import agents  # noqa: E402
from app.__main__ import serve  # noqa: E402
from geotlm_lm.core.errors import MissingDependency  # noqa: E402
from tests.app.agent_calls import CAP, assert_refused, clip, in_message  # noqa: E402

MISSING = "--mcp needs the package mcp, which is not installed; run `pip install 'geotlm-lm[mcp]'`."


def test_a_missing_package_is_told_before_the_model_is_loaded(monkeypatch):
    monkeypatch.setitem(sys.modules, "mcp", None)
    monkeypatch.setattr("geotlm_lm.Answerer.load", lambda: pytest.fail("it was loaded"))
    with pytest.raises(MissingDependency) as caught:
        serve(mcp=True)
    assert str(caught.value) == MISSING


def test_a_package_this_server_is_not_written_for_is_told(monkeypatch):
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    monkeypatch.setattr(agents, "version", lambda _: "2.3.0")
    with pytest.raises(MissingDependency, match="below 2, found 2.3.0; run `pip install"):
        agents.require_mcp()


UNKNOWN = "There is no recording "
NEITHER = "The recording is neither a name nor a data URI nor an upload; "


@pytest.mark.parametrize(
    ("recording", "begins"),
    [
        ("../private.npy", UNKNOWN),
        ("day 1/../../private.npy", UNKNOWN),
        ("./turn.npz", UNKNOWN),
        ("link.npy", UNKNOWN),
        ("up/private.npy", UNKNOWN),
        ("up/recordings/turn.npz", UNKNOWN),
        ("day 1", UNKNOWN),
        ("turn.npz\0.npy", UNKNOWN),
        ("..\\private.npy", UNKNOWN),
        ("~/private.npy", UNKNOWN),
        ("/etc/passwd", NEITHER),
        ("file:///etc/passwd", NEITHER),
        ("http://127.0.0.1:9/clip.npz", NEITHER),
        ("x" * 5000, NEITHER),
        ("example:../private", "There is no example "),
        ("data:,plain", "The clip's data URI is not in base64; "),
        ("data:;base64,UEsD*", "The clip's data URI is cut off or no base64; "),
        ("", "evidence: recording was ''"),
        (7, "evidence: recording was 7, and input should be a valid string; "),
        (
            ["turn.npz"],
            "evidence: recording was ['turn.npz'], and input should be a valid string; ",
        ),
        (None, "evidence: recording was None, and input should be a valid string; "),
    ],
    ids=lambda one: repr(one)[:30],
)
def test_what_is_no_recording_of_ours_is_refused_in_one_sentence(use, recording, begins):
    (told,) = use(("evidence", {"recording": recording}))
    assert_refused(told, begins)


def test_the_folders_own_path_is_no_name(use, folder):
    (told,) = use(("evidence", {"recording": str(folder / "turn.npz")}))
    assert_refused(told, NEITHER)


class Planted:
    def __reduce__(self):
        return pytest.fail, ("a pickle was opened",)


def bomb(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (900000, 900, 900, 3), }"
        header = header.ljust(117) + b"\n"
        lead = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little")
        archive.writestr("frames.npy", lead + header + bytes(10**6))


def test_pickles_and_bombs_are_refused_in_one_sentence(use, tmp_path):
    np.save(tmp_path / "object.npy", np.array([Planted()], dtype=object), allow_pickle=True)
    (tmp_path / "plain.pkl").write_bytes(pickle.dumps(Planted()))
    bomb(tmp_path / "bomb.npz")
    for name in ("object.npy", "plain.pkl", "bomb.npz"):
        (told,) = use(("evidence", {"recording": in_message((tmp_path / name).read_bytes())}))
        assert_refused(told, "clip")


def test_a_message_longer_than_two_recordings_is_refused_unread(agents_address):
    connection = HTTPConnection(urlsplit(agents_address).netloc, timeout=30)
    connection.putrequest("POST", f"/{agents.PATH}")
    connection.putheader("Content-Type", "application/json")
    connection.putheader("Accept", "application/json, text/event-stream")
    connection.putheader("Content-Length", str(10**10))
    connection.endheaders()
    assert connection.getresponse().status == 413
    connection.close()


@pytest.mark.parametrize(
    ("tool", "given", "begins"),
    [
        (
            "ask",
            {"question": "Which way?"},
            "ask: recording is missing; give recording and question.",
        ),
        ("ask", {"recording": CAP, "question": "x" * 2001}, "ask: question was 'xxx"),
        ("ask", {"recording": CAP, "question": " "}, "The question is empty; "),
        ("ask", {"clip": CAP}, "ask: recording is missing; "),
        (
            "evidence",
            {"recording": CAP, "path": "x"},
            "evidence: there is no parameter 'path'; it takes recording, frames, topic.",
        ),
        ("evidence", {"recording": CAP, "topic": "x" * 201}, "evidence: topic was 'xxx"),
        ("evidence", {"recording": CAP, "frames": [0]}, "evidence: frames was [0], and "),
        ("evidence", {"recording": CAP, "frames": [0, "b"]}, "evidence: frames.1 was 'b', and "),
        ("evidence", {"recording": CAP, "frames": [0, 99]}, "Frames 0:99 were "),
        ("track", {"recording": "turn.npz", "frames": [900, 950]}, "Frames 900:950 were "),
        ("track", {"recording": "turn.npz", "frames": [50, 950]}, "Frames 50:950 were "),
        ("track", {"recording": "turn.npz", "frames": [60, 50]}, "Frames 60:50 were "),
        (
            "picture",
            {"recording": "turn.npz", "frames": [50, 950], "shows": "timeline"},
            "Frames 50:950 were ",
        ),
        ("track", {"recording": CAP, "rows": 501}, "track: rows was 501, and "),
        ("track", {"recording": CAP, "turned": 45}, "track: turned was 45, and "),
        ("ask", {"recording": CAP, "question": "a", "mm_per_px": -1}, "ask: mm_per_px was -1, "),
        ("picture", {"recording": CAP, "shows": "all"}, "picture: shows was 'all', and "),
        ("simulate", {"object_name": "unicorn"}, "There is no shape 'unicorn'"),
        ("simulate", {"twist_deg": 1e9}, "simulate: twist_deg was 1000000000.0, and "),
        ("simulate", {"seed": 0.5}, "simulate: seed was 0.5, and "),
        ("nothing", {}, "There is no tool 'nothing'; "),
    ],
    ids=lambda one: repr(one)[:30],
)
def test_a_wrong_call_is_told_in_one_sentence(use, tool, given, begins):
    (told,) = use((tool, given))
    assert_refused(told, begins)


def test_nothing_that_came_inside_a_message_is_left_on_disk(use, uploads, tmp_path):
    np.save(tmp_path / "clip.npy", clip(90))
    sent = in_message((tmp_path / "clip.npy").read_bytes())
    use(("evidence", {"recording": sent}), ("evidence", {"recording": sent[:-4000]}))
    assert list(uploads.rglob("message-*")) == []
    assert list(uploads.rglob("*.npy")) == []
