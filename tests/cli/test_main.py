"""The command starts fast, says one sentence when called wrongly, and keeps a defect's trace."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest
import typer

from geotlm_lm.cli import main as main_module
from geotlm_lm.cli.options import path_of
from geotlm_lm.core.errors import (
    BelowMinimum,
    IncompatibleBundle,
    MissingDependency,
    NotReached,
    Stalled,
    TimedOut,
)
from tests.cli.running import run

WRONG_CALLS = {
    "no command": ([], "Missing command; see `geotlm-lm --help`.\n"),
    "a slip of the pen": (
        ["answr"],
        "No such command 'answr'. Did you mean 'answer'? See `geotlm-lm --help`.\n",
    ),
    "unknown flag": (["answer", "--zzz"], "No such option: --zzz; see `geotlm-lm --help`.\n"),
    "no clip": (
        ["answer", "--q", "Which way?"],
        "Missing argument 'FILE'; see `geotlm-lm --help`.\n",
    ),
    "a clip that is given twice": (
        ["answer", "a.npy", "--clip", "b.npy", "--q", "Which way?"],
        "FILE and --clip are the same: give one of them.\n",
    ),
    "no question": (
        ["answer", "clip.npy"],
        "Missing option '--q'; see `geotlm-lm --help`.\n",
    ),
    "empty question": (
        ["answer", "clip.npy", "--q", "  "],
        "The question is empty; ask something like 'Which way is it moving?'.\n",
    ),
    "question that is no text": (
        ["answer", "clip.npy", "--q", "which \udcff way"],
        "The question holds bytes that are no text; give it in UTF-8.\n",
    ),
    "frames without end": (
        ["info", "clip.npy", "--frames", "0:" + "9" * 5000],
        f"--frames '0:{'9' * 38}' was given, expected FIRST:LAST such as 40:60.\n",
    ),
    "no film to force": (
        ["watch", "a.npz", "--force"],
        "--force lets --out and other options replace files; give one of them, or leave it out.\n",
    ),
    "a clip that is no archive": (
        ["simulate-clip", "a.npy"],
        "OUT a.npy was given, expected a name that ends in .npz.\n",
    ),
}


@pytest.mark.parametrize("case", WRONG_CALLS)
def test_a_wrong_call_ends_with_one_sentence_and_code_2(capsys, case):
    arguments, sentence = WRONG_CALLS[case]
    assert run(capsys, *arguments) == (2, "", sentence)


@pytest.mark.parametrize(
    "words",
    [
        "answer --q Which?",
        "simulate --count 1 --out",
    ],
)
def test_an_empty_path_is_not_taken_for_the_current_folder(capsys, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    assert run(capsys, *words.split(), "") == (
        2,
        "",
        "An empty path was given, expected a file's or a folder's; give it.\n",
    )
    assert list(tmp_path.iterdir()) == []


def test_no_command_takes_an_empty_path():
    """Typer makes the current folder of an empty text wherever a path has no parser of its own."""
    plain, seen = [], 0
    for command in _commands(main_module.app):
        for name, hint in get_type_hints(command, include_extras=True).items():
            kind, *about = get_args(hint) if hasattr(hint, "__metadata__") else (hint,)
            if kind is Path or Path in get_args(kind):
                seen += 1
                plain += [] if about and about[0].parser is path_of else [(command, name)]
    assert plain == []
    assert seen > 30


def _commands(group):
    """The functions of a group's commands and of the groups within it."""
    return [command.callback for command in group.registered_commands] + [
        command for inner in group.registered_groups for command in _commands(inner.typer_instance)
    ]


OUTPUTS = {
    "a data set": ["simulate", "--out", "{file}"],
    "a record": ["evaluate", "--out", "{file}/a.json"],
    "a bundle": ["train", "--out", "{file}"],
}


@pytest.mark.parametrize("output", OUTPUTS)
def test_a_place_that_cannot_be_written_is_told_before_any_work(capsys, tmp_path, output):
    file = tmp_path / "file"
    file.write_text("not a folder")
    command = [word.format(file=file) for word in OUTPUTS[output]]
    assert run(capsys, *command) == (
        2,
        "",
        f"{command[1]}: nothing can be written in the folder {file} (Not a directory); "
        f"give another place.\n",
    )


@pytest.mark.parametrize("name", ["a" * 300, "link", "link/deep"])
def test_a_folder_that_cannot_be_made_is_told_before_any_work(capsys, tmp_path, name):
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    code, out, err = run(capsys, "simulate", "--out", str(tmp_path / name))
    assert (code, out) == (2, "")
    assert err.startswith(f"--out: nothing can be written in the folder {tmp_path / name} (")


def test_a_folder_is_no_name_of_a_file(capsys, tmp_path):
    said = f"--out: {tmp_path} is a folder, expected the name of a file.\n"
    assert run(capsys, "evaluate", "--out", tmp_path) == (2, "", said)


@pytest.mark.parametrize(
    "words",
    [
        "info clip.npy --fps fast",
        "simulate-clip a.npz --motion spin",
        "evaluate --seed -1",
    ],
)
def test_a_value_out_of_range_ends_with_one_sentence_and_code_2(capsys, words):
    code, out, err = run(capsys, *words.split())
    assert (code, out) == (2, "")
    option = words.split()[-2]
    assert err.startswith(f"Invalid value for '{option}': ")
    assert err.endswith("; see `geotlm-lm --help`.\n")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("error", "code"),
    [(IncompatibleBundle, 4), (BelowMinimum, 6), (MissingDependency, 7)]
    + [(TimedOut, 8), (NotReached, 9), (Stalled, 10)],
)
def test_each_repairable_error_has_its_own_exit_code(capsys, monkeypatch, error, code):
    def fail(path, **options):
        raise error("Found this; do that.")

    monkeypatch.setattr("geotlm_lm.recordings.read.read_clip", fail)
    assert run(capsys, "info", "clip.npy") == (code, "", "Found this; do that.\n")


def test_ctrl_c_ends_with_code_130_and_says_what_became_of_files_where_any_are_written(
    capsys, monkeypatch, tmp_path
):
    def interrupt(path, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("geotlm_lm.recordings.read.read_clip", interrupt)
    assert run(capsys, "info", "clip.npy") == (130, "", "Stopped.\n")
    monkeypatch.setattr("geotlm_lm.recordings.read.clips_in", interrupt)
    asked = tmp_path / "questions.txt"
    asked.write_text("Which way?\n")
    assert run(capsys, "batch", "a", "--questions", str(asked), "--out", "c") == (
        130,
        "",
        "Stopped; files already complete are kept.\n",
    )


@pytest.mark.parametrize(
    "words",
    [
        "answer {} gone.npy --q Which?",
        "chat {} gone.npy",
        "info {} gone.npy",
        "track {} gone.npy",
        "watch {} gone.npy",
        "batch {} gone.npy --questions {questions} --out {questions}.jsonl",
    ],
)
def test_the_option_of_before_means_the_same_as_the_argument(capsys, tmp_path, words):
    questions = tmp_path / "questions.txt"
    questions.write_text("Which way?\n")
    alias = {"watch": "--source", "batch": "--clips"}.get(words.split()[0], "--clip")
    by_argument, by_option = (
        run(capsys, *words.format(option, questions=questions).split()) for option in ("", alias)
    )
    assert by_argument == by_option
    assert by_argument[2].startswith("gone.npy: no such ")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
@pytest.mark.parametrize("words", [["--version"], ["info", "{clip}"]])
def test_an_output_that_takes_no_more_is_told_in_one_sentence(tmp_path, words):
    np.save(tmp_path / "clip.npy", np.full((4, 48, 64, 3), 100, np.uint8))
    words = [word.format(clip=tmp_path / "clip.npy") for word in words]
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "geotlm_lm", *words], stdout=full, stderr=-1, text=True
        )
    assert (done.returncode, done.stderr) == (
        2,
        "The output cannot be written (No space left on device); make room, or give another "
        "place.\n",
    )


def test_an_output_that_nobody_reads_ends_the_command_silently():
    reads, writes = os.pipe()
    os.close(reads)
    command = [sys.executable, "-m", "geotlm_lm", "--version"]
    done = subprocess.run(command, stdout=writes, stderr=-1, text=True)
    os.close(writes)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.parametrize("defect", [ZeroDivisionError, FileNotFoundError])
def test_a_defect_keeps_its_trace(monkeypatch, defect):
    def break_down(path, **options):
        raise defect

    monkeypatch.setattr("geotlm_lm.recordings.read.read_clip", break_down)
    with pytest.raises(defect):
        main_module.main(["info", "clip.npy"])


COMMANDS = sorted(set(typer.main.get_command(main_module.app).commands) - {"bench"})


@pytest.mark.parametrize("command", COMMANDS)
def test_every_commands_help_shows_an_example(capsys, command):
    code, out, _ = run(capsys, command, "--help")
    assert code == 0
    assert f"Example: geotlm-lm {command}" in " ".join(out.split())


def test_every_option_says_what_it_is():
    for command in typer.main.get_command(main_module.app).commands.values():
        assert [option.name for option in command.params if not option.help] == []


def test_a_wrong_path_is_told_before_the_model_is_loaded():
    program = (
        "import sys\n"
        "from geotlm_lm.cli.main import main\n"
        "try: main(['answer', 'gone.npy', '--q', 'Which way?'])\n"
        "except SystemExit as stop: print(stop.code)\n"
        "print('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.split() == ["3", "False"]
    assert done.stderr == "gone.npy: no such file or folder; check the path.\n"


ENDLESS = """
import sys, time
from geotlm_lm.cli import main
def info():
    try:
        print("begun", flush=True)
        time.sleep({seconds})
    finally:
        print("closed", flush=True)
main.app.registered_commands[:] = []
main.app.command()(info)
main.main(["info"])
"""


def test_a_request_to_end_closes_what_is_open_and_ends_of_the_signal():
    program = [sys.executable, "-c", ENDLESS.format(seconds=60)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(program, **pipes) as running:
        assert running.stdout.readline() == "begun\n"
        running.terminate()
        out, err = running.communicate(timeout=30)
    assert (running.returncode, out, err) == (-signal.SIGTERM, "closed\n", "Stopped.\n")


def test_after_a_command_the_signal_means_what_it_did(capsys):
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(SystemExit):
        main_module.main(["--version"])
    assert capsys.readouterr().out == "geotlm-lm 0.1.0\n"
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_missing_toolkit_ends_with_one_sentence_and_code_7(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "gradio", None)
    assert run(capsys, "app") == (
        7,
        "",
        "The app needs gradio, which is not installed; run `pip install 'geotlm-lm[app]'`.\n",
    )


@pytest.mark.parametrize("is_served", [True, False])
def test_port_recordings_and_the_wish_to_serve_agents_are_handed_on(capsys, monkeypatch, is_served):
    served = []

    def serve(port, *, mcp, recordings):
        served.append((port, mcp, recordings))

    monkeypatch.setattr("app.__main__.serve", serve)
    options = ("--port", "7999", "--recordings", "here")
    run(capsys, "app", *options, *["--mcp"] * is_served)
    assert served == [(7999, is_served, Path("here"))]


def test_the_page_started_as_a_module_takes_the_same_options():
    started = subprocess.run(
        [sys.executable, "-m", "app", "--port", "70000"], capture_output=True, text=True, timeout=60
    )
    assert started.returncode == 2
    assert started.stderr.startswith("Invalid value for '--port': ")
