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
        "Which way is the cap turning?",
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
    clockwise = "Clockwise, in the camera image."
    assert talk[0] == clockwise
    assert talk[1].endswith(f"%: {clockwise}")
    assert talk[2].startswith("It turns counterclockwise, about ")
    assert talk[2].endswith(", played backwards.")
    assert talk[3].startswith("It turns counterclockwise, about ")
    assert talk[4].startswith("I cannot tell tightening from loosening: tell me which side touches")
    assert talk[5].startswith("Noted: camera image")
    assert talk[6].startswith("It tightens: clockwise in the camera image, right-hand thread")
    assert talk[8].startswith("Opposite: the first is going clockwise, the second going counter")
    assert talk[9] == "I read English only; please ask in English."


def test_a_talk_that_nobody_reads_on_ends_silently():
    command = [sys.executable, "-m", "geotlm_lm", "chat"]
    talking = subprocess.Popen(
        [*command, "--clip", str(EXAMPLES / "bead_right.npz")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )
    talking.stdin.write(b"which way?\nand how far?\n")
    talking.stdin.close()
    assert talking.stdout.read(3) == b"Rig"
    talking.stdout.close()
    told = talking.stderr.read().decode().splitlines()
    assert [line for line in told if not line.startswith("note: ")] == []
    assert talking.wait() == 1


def test_the_reasons_for_a_turn_add_up_to_it(capsys):
    from geotlm_lm.cli.main import main

    clip = EXAMPLES / "bottle_cap_clockwise.npz"
    with pytest.raises(SystemExit):
        main(["answer", "--clip", str(clip), "--q", "Which way?", "--why", "--json"])
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    place, *own, measured, sums, amounts, frame, _ = told["why"]["steps"]
    assert place.startswith("Contact fills ")
    assert own == [
        "The upper half goes right, the lower half left, the left half up, the right half down.",
        "This adds up, the common shift cancels.",
        "So it turns clockwise, in the camera image.",
    ]
    assert measured.startswith("Measured: ")
    assert amounts.startswith("Measured from the first frame to the last: a turn clockwise of ")
    assert sums == (
        "The common shift cancels in the differences of the halves, which add up clockwise."
    )
    assert frame.startswith("The answer is told in this frame: camera image")
    assert told["why"]["steps"][-1].startswith("Therefore: It turns clockwise, about ")
