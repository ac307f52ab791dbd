"""Commands the README shows exist, with the options it shows."""

import re
import shlex
from pathlib import Path

import pytest
import typer

from geotlm_lm.cli.main import app

README = Path(__file__).resolve().parents[2] / "README.md"
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
SHELLS = ("", "bash", "console", "sh")


def shown_commands():
    if not README.exists():
        return []
    blocks = [text for language, text in FENCED.findall(README.read_text()) if language in SHELLS]
    text = "\n".join(blocks).replace("\\\n", " ")
    lines = (line.removeprefix("$ ").strip() for line in text.splitlines())
    return sorted({line for line in lines if line.startswith("geotlm-lm ")})


@pytest.mark.parametrize("line", shown_commands() or ["geotlm-lm --help"])
def test_a_command_in_the_readme_exists_with_its_options(line):
    words = shlex.split(line, comments=True)[1:]
    command = typer.main.get_command(app)
    while words and not words[0].startswith("-"):
        if not hasattr(command, "commands"):
            break
        assert words[0] in command.commands, f"`{line}`: no such command"
        command = command.commands[words.pop(0)]
    known = {option for param in command.params for option in param.opts} | {"--help", "-h"}
    used = {word.split("=")[0] for word in words if word.startswith("--")}
    assert used <= known
