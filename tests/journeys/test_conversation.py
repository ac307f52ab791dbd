"""A talk with the shipped model, through the command, as somebody at a terminal would have it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import geotlm_lm

EXAMPLES = Path(__file__).resolve().parents[2] / "app" / "examples"

pytestmark = pytest.mark.skipif(
    not (Path(geotlm_lm.__file__).parent / "bundle").is_dir(), reason="needs the trained bundle"
)


@pytest.fixture(scope="module")
def talk():
    """The answers of one run of the command to lines from a pipe."""
    lines = [
        "Which way is it turning?",
        "Are you sure?",
        "And played backwards?",
        "Seen from the object's side?",
        "Is it being tightened?",
        "Right-hand thread, touched at the head.",
        "Is it being tightened?",
        f"/clip {EXAMPLES / 'hex_nut_counterclockwise.npz'}",
        "Do they turn the same way?",
        "Wohin dreht sich der Deckel?",
        "/quit",
    ]
    command = [sys.executable, "-m", "geotlm_lm", "chat"]
    done = subprocess.run(
        [*command, "--clip", str(EXAMPLES / "bottle_cap_clockwise.npz")],
        input="\n".join(lines),
        capture_output=True,
        text=True,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_the_talk_goes_as_it_should(talk):
    clockwise = talk[0]
    assert clockwise.startswith("It turns clockwise, about ")
    assert clockwise.endswith(", in the camera image.")
    assert talk[1].startswith("About ")
    assert talk[1].endswith(f"%: i{clockwise[1:]}")
    assert talk[2].startswith("It turns counterclockwise, about ")
    assert talk[2].endswith(", played backwards.")
    assert talk[3].startswith("It turns clockwise, about ")
    assert talk[3].endswith(", seen from the object's side, played backwards.")
    assert talk[4].startswith("If it is an ordinary right-hand thread seen from its head, ")
    noted = "Noted: right-hand thread, touched at the head. Yes: it turns clockwise, about "
    assert talk[5].startswith(noted)
    assert talk[6].startswith(("Yes: it turns clockwise", "It tightens: it turns clockwise"))
    assert talk[8].startswith("No: the first turns clockwise, about ")
    assert "the second turns counterclockwise, about " in talk[8]
    assert talk[9] == "Please ask in English."


def test_a_talk_that_nobody_reads_on_ends_silently():
    command = [sys.executable, "-m", "geotlm_lm", "chat"]
    talking = subprocess.Popen(
        [*command, "--clip", str(EXAMPLES / "bead_right.npz")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )
    talking.stdin.write(b"Which way is it sliding?\n")
    talking.stdin.flush()
    assert talking.stdout.read(3) == b"It "
    talking.stdout.close()
    talking.stdin.write(b"How far?\n")
    talking.stdin.close()
    told = talking.stderr.read().decode().splitlines()
    assert [line for line in told if not line.startswith("note: ")] == []
    assert talking.wait() == 1


def test_the_reasons_for_a_turn_add_up_to_it(capsys):
    from geotlm_lm.cli.main import main

    clip = EXAMPLES / "bottle_cap_clockwise.npz"
    with pytest.raises(SystemExit):
        main(["answer", "--clip", str(clip), "--q", "Which way is it turning?", "--why", "--json"])
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    place, measured, sums, amounts, own, frame, _ = told["why"]["steps"]
    assert place.startswith("Contact fills ")
    assert measured.startswith("The whole contact ")
    assert amounts.startswith("Measured from the first frame to the last: a turn clockwise of ")
    assert own.startswith("The language model itself: turn cw (")
    assert sums == (
        "The common shift cancels in the differences of the halves, which add up clockwise."
    )
    assert frame.startswith("The answer is told in this frame: camera image")
    assert told["why"]["steps"][-1] == f"Therefore: {told['text']}"
