"""The clips offered on the page are what their README says, command by command."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from app.example_clips import FOLDER

from geotlm_lm import read_clip
from geotlm_lm.cli.main import main

CLIPS = sorted(FOLDER.glob("*.npz"))
COMMANDS = re.findall(r"^geotlm-lm (.*)$", (FOLDER / "README.md").read_text(), re.MULTILINE)


def test_every_clip_on_offer_has_its_command():
    named = sorted(Path(shlex.split(command)[2]).name for command in COMMANDS)
    assert named == [path.name for path in CLIPS]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_clip_is_what_its_command_makes(tmp_path, command):
    words = shlex.split(command)
    name, words[2] = Path(words[2]).name, str(tmp_path / "clip.npz")
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 0
    made, kept = read_clip(words[2]), read_clip(FOLDER / name)
    # Another processor may round a few pixels differently.
    assert np.abs(made.frames.astype(int) - kept.frames).mean() < 0.05
    assert np.abs(made.background.astype(int) - kept.background).mean() < 0.05
    assert made.notes == kept.notes


@pytest.mark.parametrize("path", CLIPS, ids=lambda path: path.stem)
def test_a_clips_name_tells_its_object_and_motion(path):
    label = json.loads(str(np.load(path)["label"]))
    assert path.stem == f"{label['object']}_{label['motion']}"
