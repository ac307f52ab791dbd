"""`report protocols` as a user calls it; the protocols themselves are replaced."""

from pathlib import Path

import pytest

from geotlm_lm.cli.main import main
from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments import protocols
from geotlm_lm.experiments.protocol_rows import TABLES
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
from tests.backbone.small_files import write_small

TRAINING = {"head_rate": 1e-3, "dgr_rate": 3e-4, "weight_decay": 0.01, "batch": 32}


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as exit_info:
        main(["report", "protocols", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return exit_info.value.code, printed.out, printed.err


@pytest.fixture
def calls(tmp_path, monkeypatch):
    """Run in an empty folder; note what the protocols are asked for."""
    found = []

    def noted(backbone, sizes, *, folder, tables, backbone_name, about, command, progress):
        found.append((backbone, sizes, folder, tables))
        progress("rotation, five-fold, rows", 55, 55)
        config = {"objects": list(sizes.objects), "tables": [], "epochs": sizes.epochs}
        config |= {"backbone": backbone_name, "backbone_digest": "abc", "training": TRAINING}
        numbers = {"tasks": {"rotation": NO_ROWS}}
        return RunRecord("protocols", command, sizes.seed, 1.0, numbers, config | about)

    monkeypatch.setattr(protocols, "run_protocols", noted)
    monkeypatch.chdir(tmp_path)
    return found


NO_ROWS = {
    "clips": 0,
    "truths": {},
    "unreadable_left_out": 0,
    "seconds_from_nothing": 60.0,
    "protocols": {
        name: {"rows": {"a": {"by_object": {}}}, "differences": [], "folds": []}
        for name in ("five-fold", "leave-one-object-out")
    },
}


@pytest.fixture(autouse=True)
def _no_row_details(monkeypatch):
    from geotlm_lm.reports import protocols as page

    monkeypatch.setattr(page, "row_table", lambda protocol: "rows")


def test_a_whole_run_of_the_embedded_backbone_is_recorded_with_its_page(capsys, calls):
    code, out, err = run(capsys)
    assert code == 0
    ((_, sizes, folder, tables),) = calls
    assert (sizes.clips, sizes.epochs, sizes.seed) == (100, 30, 42)
    assert sizes.objects == tuple(EVERYDAY_OBJECTS)
    assert len(sizes.objects) == 12
    assert (folder, tables) == (Path("runs/protocols"), tuple(TABLES))
    record = RunRecord.load(Path("reports/recorded/protocols.json"))
    assert record.config["backbone"] == "embedded"
    page = Path("reports/protocols.md").read_text()
    assert page.startswith("# The paper's protocols")
    assert "## Folds" in out
    assert "rotation, five-fold, rows: 55 of 55\n" in err


def test_one_table_is_printed_and_recorded_nowhere(capsys, calls):
    code, _, _ = run(capsys, "--only", "ablation", "--only", "frames", "--clips", 4)
    assert code == 0
    assert calls[0][3] == ("ablation", "frames")
    assert calls[0][1].clips == 4
    assert not Path("reports").exists()
    run(capsys, "--only", "frames", "--out", "mine.json", "--table", "mine.md")
    assert RunRecord.load(Path("mine.json")).name == "protocols"
    assert Path("mine.md").exists()


def test_a_released_encoder_takes_the_backbones_place(capsys, calls, tmp_path):
    weights = write_small("anytouch2", tmp_path / "file")
    code, _, _ = run(capsys, "--weights", weights, "--heads", 2, "--out", "theirs.json")
    assert code == 0
    record = RunRecord.load(Path("theirs.json"))
    assert record.config["backbone"] == "AnyTouch 2"
    assert record.config["encoder"]["encoder"] == "anytouch2"
    assert calls[0][0].digest() == record.config["encoder"]["digest"]
    assert not Path("reports").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--encoder", "t3"], "--encoder and --heads need --weights with the encoder's file.\n"),
        (
            ["--weights", "a.pth", "--model", "b"],
            "--model and --weights exclude each other: give one of them.\n",
        ),
    ],
)
def test_options_that_do_not_go_together_are_refused(capsys, calls, arguments, sentence):
    assert run(capsys, *arguments) == (2, "", sentence)
    assert not calls


def test_an_unknown_table_is_refused_with_one_sentence(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sentence = "there is no table 'slides'; choose one of rotation, sliding, ablation, frames.\n"
    assert run(capsys, "--only", "slides") == (2, "", sentence)


def test_a_place_that_cannot_be_written_is_told_before_the_work(capsys, calls):
    Path("taken").mkdir()
    code, _, err = run(capsys, "--out", "taken")
    assert (code, err) == (2, "--out: taken is a folder, expected the name of a file.\n")
    assert not calls
