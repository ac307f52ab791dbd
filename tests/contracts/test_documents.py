"""What the README and the documentation show is run as it stands there, page by page.

Commands run in this process, in a folder with the files that a reader is taken to have. What
cannot run in a test is parsed, so that its command and its options exist; `ONLY_CHECKED` says why.
"""

import io
import os
import re
import shlex
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
import typer

from geotlm_lm.cli import main as cli
from tests.recordings.bag_files import TOPIC, even_ns, raw, write_bag

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SHELL, PYTHON, SHOWN = ("bash", "console"), "python", ("text", "json", "")
INLINE = re.compile(r"`((?:geotlm-lm|\.venv/bin/\S+|zensical|pip) [^`]+)`")
PRINTED = re.compile(r"^ *print\(.*\)  # (.+)$", re.MULTILINE)

ONLY_CHECKED = {
    "geotlm-lm app": "serves until it is stopped; tests/journeys asks such a server",
    "geotlm-lm watch 0": "needs a camera",
    "geotlm-lm doctor 0": "needs a camera",
    "geotlm-lm train": "trains for minutes or hours",
    "geotlm-lm evaluate": "measures for minutes, on data that is not part of the repository",
    "geotlm-lm bench": "measures for minutes; what it writes is tested in tests/benchmarks",
    "geotlm-lm info --weights": "describes a file that only its authors release",
    "geotlm-lm label": "needs a robot's data set; tests/data_sets writes one and labels it",
    "geotlm-lm track robot": "likewise",
    "geotlm-lm answer robot": "likewise",
    "geotlm-lm batch robot": "likewise",
    "geotlm-lm track recording.mov --rerun": "needs the extra rerun; tests/track and tests/cli do",
    "geotlm-lm answer recording.mov --rerun": "needs the extra rerun; tests/cli has it",
    "geotlm-lm manifest": "needs a data set's pictures",
}
"""Beginning of a command of ours -> why it is not run here."""

NOT_OURS = {
    "python3 -m venv": "installs; .ci/run and tests/contracts/test_wheel.py do",
    "pip install": "installs",
    "torchrun": "starts several processes of a training, which tests/training/test_ranks.py does",
    ".venv/bin/pip install": "installs",
    ".venv/bin/pytest": "is the run that this test is part of",
    "rerun": "opens a viewer",
    "zensical": "builds the site; tests/contracts/test_site.py does",
    ".ci/run": "runs this test",
}
"""Beginning of another program's command -> why it is not run here."""

SERVED = "http://127.0.0.1:7860"
"""A block that asks a server; tests/journeys/test_programs.py runs it against one."""


@dataclass(frozen=True)
class Command:
    """A line of a shell, with what a page types into it and says it prints."""

    line: str
    typed: str = ""
    printed: str | None = None

    @property
    def words(self):
        return shlex.split(self.line, comments=True)

    @property
    def is_ours(self):
        return self.words[0] in ("geotlm-lm", ".venv/bin/geotlm-lm")

    @property
    def is_only_checked(self):
        line = " ".join(["geotlm-lm", *self.words[1:]])
        return any(line.startswith(beginning) for beginning in ONLY_CHECKED)


def blocks(page):
    return [(language, code) for language, code in FENCE.findall(page.read_text())]


def commands(language, code):
    """Return the commands of a block that no server is asked in."""
    if SERVED in code:
        return []
    code = code.replace("\\\n", " ")
    if language == "bash":
        parts = (part.strip() for line in code.splitlines() for part in line.split(" && "))
        return [Command(part) for part in parts if part and not part.startswith("#")]
    _, *shown = re.split(r"^\$ ", code, flags=re.MULTILINE)
    return [shown_command(*one.split("\n", 1)) for one in shown]


def shown_command(line, below):
    lines = below.strip("\n").split("\n")
    typed = [one.removeprefix("> ") for one in lines if one.startswith("> ")]
    printed = [one for one in lines if one and not one.startswith("> ")]
    return Command(line, "\n".join([*typed, ""]), "\n".join(printed))


def told_in_passing(page):
    return [Command(line) for line in INLINE.findall(FENCE.sub("", page.read_text()))]


def all_commands():
    for page in PAGES:
        yield from told_in_passing(page)
        for language, code in blocks(page):
            if language in SHELL:
                yield from commands(language, code)


@pytest.fixture
def readers_folder(tmp_path, monkeypatch):
    """Go to a folder with a checkout's examples and a reader's own recordings."""
    programs = Path(sys.executable).parent  # a script of a page finds what is tested
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")
    shutil.copytree(ROOT / "app/examples", tmp_path / "app/examples")
    example = np.load(ROOT / "app/examples/hex_nut_counterclockwise.npz")
    idle, (first, second, third, last) = example["background"], example["frames"]
    shown = [idle] * 20 + [first] * 15 + [second] * 8 + [third] * 8 + [last] * 20
    for name, code in (("recording.avi", "MJPG"), ("recording.mov", "mp4v")):
        size = idle.shape[1::-1]
        film = cv2.VideoWriter(str(tmp_path / name), cv2.VideoWriter_fourcc(*code), 25, size)
        for frame in shown:
            film.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
        film.release()
    images = list(zip(shown, even_ns(len(shown)), strict=True))
    bag = write_bag(tmp_path / "bag", {TOPIC: [raw(*one) for one in images]})
    shutil.move(bag / "bag.mcap", tmp_path / "run.mcap")
    np.save(tmp_path / "opencv_frames.npy", example["frames"][..., ::-1])
    np.save(tmp_path / "heights.npy", np.pad(np.ones((30, 12)), 20))
    cv2.imwrite(str(tmp_path / "idle.png"), cv2.cvtColor(idle, cv2.COLOR_RGB2BGR))
    recordings = tmp_path / "recordings"
    recordings.mkdir()
    for name in ("cable_up.npz", "coin_press.npz"):
        shutil.copy(ROOT / "app/examples" / name, recordings)
    (tmp_path / "questions.txt").write_text("Which way does it go?  # a comment\nHow far?\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


README, *OTHERS = PAGES


@pytest.mark.parametrize(
    "page",
    [README, *(pytest.param(page, marks=pytest.mark.slow) for page in OTHERS)],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_what_a_page_shows_runs_and_prints_what_it_says(page, readers_folder, monkeypatch, capsys):
    names = {}
    for language, code in blocks(page):
        if language == PYTHON and SERVED not in code:
            run_python(code, names, capsys)
        for command in commands(language, code) if language in SHELL else ():
            run_command(command, monkeypatch, capsys)
    for command in told_in_passing(page):
        run_command(command, monkeypatch, capsys)


def run_python(code, names, capsys):
    capsys.readouterr()
    exec(code, names)
    if expected := PRINTED.findall(code):
        assert len(expected) == code.count("print("), f"some lines are not told:\n{code}"
        assert capsys.readouterr().out.splitlines() == expected


def run_command(command, monkeypatch, capsys):
    if not command.is_ours or command.is_only_checked:
        return
    monkeypatch.setattr("sys.stdin", io.StringIO(command.typed))
    capsys.readouterr()
    with pytest.raises(SystemExit) as ended:
        cli.main(command.words[1:])
    told = capsys.readouterr()
    assert ended.value.code == 0, f"`{command.line}`: {told.err}"
    if command.printed is not None:
        assert told.out.rstrip("\n") == command.printed


@pytest.mark.parametrize("line", sorted({one.line for one in all_commands() if one.is_ours}))
def test_a_command_that_is_shown_exists_with_its_options(line):
    words = Command(line).words[1:]
    command = typer.main.get_command(cli.app)
    while words and hasattr(command, "commands"):
        assert words[0] in command.commands, f"`{line}`: no such command"
        command = command.commands[words.pop(0)]
    known = {option for param in command.params for option in param.opts} | {"--help", "-h"}
    assert {word.split("=")[0] for word in words if word.startswith("--")} <= known


def test_every_block_says_what_it_is():
    known = {*SHELL, PYTHON, *SHOWN}
    assert {language for page in PAGES for language, _ in blocks(page)} <= known
    for page in PAGES:
        fences = [line for line in page.read_text().splitlines() if line.startswith("```")]
        assert len(fences) == 2 * len(blocks(page)), f"{page}: a block was not read"


def test_every_other_program_is_one_that_is_known():
    others = {one.line for one in all_commands() if not one.is_ours}
    assert [line for line in others if not line.startswith(tuple(NOT_OURS))] == []


def test_the_walk_names_files_that_are_there_in_words_and_in_the_picture():
    named = re.compile(r"\b[a-z_]+(?:/[a-z_]+)*\.py\b")
    in_words = set(named.findall((ROOT / "docs" / "walk.md").read_text()))
    in_picture = set(named.findall((ROOT / "docs" / "walk.svg").read_text()))
    assert len(in_picture) > 20
    assert in_picture <= in_words
    assert [path for path in in_words if not (ROOT / "geotlm_lm" / path).is_file()] == []
