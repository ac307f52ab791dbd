"""`watch --until` ends by what it saw: with exit code 0, or with the one that tells why not."""

import json
import sys

import pytest

from geotlm_lm.answering.monitor import Condition
from geotlm_lm.core.errors import UsageError
from geotlm_lm.query.lines import read
from geotlm_lm.query.program import filled, of
from geotlm_lm.query.quantities import find
from tests.cli import running
from tests.cli.recorded_touch import Measuring, saved_touch


class Reading(Measuring):
    """Tracks by measurement alone, and takes a condition for a program's line."""

    def condition(self, text, *, frame, is_negated=False):
        if "?" in text:
            raise UsageError(f"The condition '{text}' was not surely understood.")
        line, _, amount = text.partition(" by ")
        numbers = [each.quantity for each in find(amount)]
        holds = filled(read(line), numbers).answers[0]
        return Condition(text, of("not", holds) if is_negated else holds, frame, 1.0, text)


@pytest.fixture(autouse=True)
def _model_stands_in(monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda folder: Reading())


@pytest.fixture
def recording(tmp_path):
    return saved_touch(tmp_path)


def run(capsys, *arguments):
    return running.run(capsys, "watch", *arguments)


TURNS = "> amount cw #1 by 20 degrees"


def test_it_ends_at_the_frame_at_which_the_condition_holds(capsys, recording):
    code, out, err = run(capsys, recording, "--until", TURNS)
    assert code == 0
    assert out.count("\n") == 1
    assert f"{TURNS} seen from the sensor, " in out
    assert " sure, " in out
    assert "degrees" in out
    assert 35 <= int(out.split("frame ")[1].split(":")[0]) <= 50
    assert f"note: Waiting until {TURNS}." in err


def test_verdicts_are_json_lines_beside_the_events(capsys, recording):
    code, out, _ = run(capsys, recording, "--until", TURNS, "--json")
    kinds = [json.loads(line)["type"] for line in out.splitlines()]
    verdict = json.loads(out.splitlines()[kinds.index("verdict")])
    assert code == 0
    assert verdict["holds"]
    assert verdict["probability"] >= 0.95
    assert kinds[-1] == "account"


@pytest.mark.parametrize(
    ("options", "code", "why"),
    [
        (("--until", "> amount cw #1 by 80 degrees"), 9, "did not hold before the recording ended"),
        (("--until", TURNS, "--timeout", 1), 8, "did not hold within 1 s"),
        (("--until", "what?"), 2, "not surely understood"),
        (("--run", "true"), 2, "give --every as well"),
        (("--timeout", 3), 2, "give one of them as well"),
        (("--until", TURNS, "--timeout", 0), 2, "expected more than 0 seconds"),
        (("--every", TURNS, "--run", "no-such-program"), 2, "no program 'no-such-program'"),
        (("--every", TURNS, "--run", "'open"), 2, "cannot be split into words"),
        (("--until", TURNS, "--sure", 2), 2, "expected 0.5 to below 1"),
    ],
)
def test_why_nothing_held_is_told_by_the_exit_code(capsys, recording, options, code, why):
    found, _, err = run(capsys, recording, *options)
    assert (found, why in err) == (code, True)


def test_a_condition_is_refused_before_a_camera_is_opened(capsys):
    code, _, err = run(capsys, "/dev/video99", "--until", "what?")
    assert (code, "not surely understood" in err) == (2, True)


def test_while_something_stays_so_nothing_ends_it(capsys, recording):
    code, out, _ = run(capsys, recording, "--while", "not turn")
    assert code == 0
    assert 25 <= int(out.split("frame ")[1].split(":")[0]) <= 35


def test_of_several_the_first_that_holds_ends_it(capsys, recording):
    later, sooner = "> amount cw #1 by 25 degrees", "> amount cw #1 by 10 degrees"
    code, out, _ = run(capsys, recording, "--until", later, "--until", sooner)
    assert code == 0
    assert sooner in out
    assert later not in out


def test_a_command_is_started_each_time_and_reads_the_verdict(capsys, recording, tmp_path):
    written = tmp_path / "verdicts"
    program = tmp_path / "append.py"
    program.write_text(f"import sys; open({str(written)!r}, 'a').write(sys.stdin.read() + '\\n')")
    options = "--every", "> path turn #1 by 8 degrees", "--run", f"{sys.executable} {program}"
    code, out, _ = run(capsys, recording, *options)
    assert code == 0
    told = [json.loads(line) for line in written.read_text().splitlines()]
    assert len(told) == out.count(" sure, ") >= 3
    assert all(each["holds"] and each["condition"] == options[1] for each in told)
