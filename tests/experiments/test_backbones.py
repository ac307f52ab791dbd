"""Backbones of several sizes: every row is of its own model, and a stopped run goes on."""

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.evened import EVENED_SHAPE
from geotlm_lm.backbone.stem import FLOW_SCALE_PX, PATCH_INPUT_DIM
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.cli.main import main
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.experiments import backbones as experiment
from geotlm_lm.experiments.backbones import (
    BACKBONES,
    SHIPPED,
    BackboneBudget,
    BackboneSize,
    compare_backbones,
    judge,
)
from geotlm_lm.reports.backbones import backbones_page, backbones_table
from geotlm_lm.training import examples
from geotlm_lm.training.config import DEFAULT
from geotlm_lm.training.dense import AMOUNT_SCALES, DenseHeads, dense_batch
from geotlm_lm.training.examples import Examples
from tests.training.in_process import InProcess

SMALL, LARGER = BackboneSize(8, 1, 1), BackboneSize(16, 1, 2)


@pytest.fixture
def run(monkeypatch, tmp_path):
    monkeypatch.setattr(examples, "CHUNK_CLIPS", 12)
    monkeypatch.setattr(examples, "ProcessPoolExecutor", InProcess)

    def compare(**backbones):
        return compare_backbones(
            folder=tmp_path,
            budget=BackboneBudget(clips=12, test_clips=12, steps=2, batch=4),
            seed=0,
            workers=1,
            backbones=backbones,
        )

    return compare


def test_every_size_is_pretrained_judged_and_timed_and_a_second_run_only_judges(run, monkeypatch):
    record = run(small=SMALL, larger=LARGER)
    first, second = record.numbers["rows"]
    assert first["parameters"] < second["parameters"]
    for row in (first, second):
        assert 0 < row["ms_median"] <= row["ms_p95"]
        assert 0 <= row["kind"] <= 1
        assert 0 <= row["amount"] <= 1
        assert row["missed"] > 0
    monkeypatch.setattr(
        "geotlm_lm.training.pretraining._Learner.step", lambda *_: pytest.fail("trained")
    )
    again = run(small=SMALL).numbers["rows"][0]
    assert [again[name] for name in ("kind", "missed", "amount")] == [
        first[name] for name in ("kind", "missed", "amount")
    ]
    page = backbones_page(record)
    assert backbones_table(record) in page
    assert "pretrained for 2 steps of 4 clips on the same 12 simulated clips" in page


def test_the_shipped_size_is_among_those_compared():
    assert list(BACKBONES.values()).count(SHIPPED) == 1
    assert SHIPPED.width == DEFAULT.backbone_width
    assert len(set(BACKBONES.values())) >= 3
    assert min(size.width for size in BACKBONES.values()) >= 2 * PATCH_INPUT_DIM


class Knowing:
    """Stands for a backbone: hands out tokens that say what the read-outs are to say."""

    def __init__(self, tokens):
        self.tokens = tokens

    def encode_inputs(self, inputs):
        return self.tokens


@pytest.mark.parametrize(
    ("share_told", "missed", "amount"), [(1.0, 0.0, 1.0), (0.7, 0.3, 0.0), (0.0, 1.0, 0.0)]
)
def test_what_is_told_is_held_against_the_truth(share_told, missed, amount):
    rng = np.random.default_rng(0)
    displacement = rng.normal(0, 4, (2, 2, 14, 14, 2))
    clips = Examples(
        inputs=np.zeros((2, 2, 14, 14, PATCH_INPUT_DIM), np.float16),
        evened=np.zeros((2, *EVENED_SHAPE), np.float16),
        displacement_px=displacement.astype(np.float16),
        contact=np.ones((2, 2, 14, 14), np.float16),
        depth_mm=np.zeros((2, 2, 14, 14), np.float16),
        labels=(
            MotionLabel(Motion.CLOCKWISE, rotation_deg=12.0),
            MotionLabel(Motion.LEFT, slide_x_mm=-1.5),
        ),
        objects=("coin", "key"),
    )
    heads = DenseHeads(9)
    for head in (heads.patch, heads.kind, heads.amount):
        torch.nn.init.eye_(head.weight)
        torch.nn.init.zeros_(head.bias)
    _, truth = dense_batch(clips, np.arange(2), "cpu")
    patches = torch.zeros(2, 2, 14, 14, 9)
    patches[..., :2] = share_told * truth.displacement / FLOW_SCALE_PX
    words = torch.zeros(2, 9)
    scales = torch.tensor(AMOUNT_SCALES)
    words[:, :2] = torch.log1p(share_told * truth.amount.nan_to_num() / scales)
    with torch.no_grad():  # the kinds are told right whatever the amounts
        heads.kind.weight.zero_()
        heads.kind.bias[truth.kind[0]] = 1.0
    found = judge(Knowing(Tokens(words, patches)), heads, clips)
    assert found["missed"] == pytest.approx(missed, abs=1e-4)
    assert found["amount"] == amount
    assert found["kind"] == 0.5


def test_the_command_writes_record_and_table(run, monkeypatch, tmp_path, capsys):
    record = run(small=SMALL)
    asked = []

    def compare(**given):
        asked.append((given["budget"], given["seed"], given["workers"], given["folder"]))
        return record

    monkeypatch.setattr(experiment, "compare_backbones", compare)
    out, table = tmp_path / "backbones.json", tmp_path / "backbones.md"
    arguments = ["--run-folder", str(tmp_path / "run"), "--out", str(out), "--table", str(table)]
    arguments += ["--clips", "200", "--test-clips", "30", "--steps", "7"]
    arguments += ["--seed", "5", "--workers", "3"]
    with pytest.raises(SystemExit) as stopped:
        main(["report", "backbones", *arguments])
    assert stopped.value.code == 0
    assert asked == [(BackboneBudget(200, 30, 7), 5, 3, tmp_path / "run")]
    assert backbones_table(record) in capsys.readouterr().out
    assert table.read_text() == backbones_page(record)
    assert out.is_file()
