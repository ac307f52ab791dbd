"""Laws: ranks together learn what one process learns, and their checkpoint goes on on one."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.training import language
from geotlm_lm.training.fit import load_checkpoint
from geotlm_lm.training.ranks import ALONE, Ranks, device_named
from tests.training.shared_steps import STEPS, curves

ROOT = Path(__file__).resolve().parents[2]
STOPPED_AT = 4
MOST_APART = 1.5e-3
"""Most that weights may be apart, relative to their size, after six steps. Two ranks sum in another
order: measured 4e-4 and 5e-4; single weights with next to no gradient move by up to 4e-3.
Gradients 3 % off come to 2e-3 to 2e-2."""


@pytest.fixture(scope="module", autouse=True)
def _as_ranks_do():
    threads, pairs = torch.get_num_threads(), language.VOCABULARY_PAIRS
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)
    language.VOCABULARY_PAIRS = pairs


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("alone")
    return folder, curves(folder, ALONE)


@pytest.fixture(scope="module")
def together(tmp_path_factory):
    folder = tmp_path_factory.mktemp("together")
    launch = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node=2"]
    subprocess.run(
        [*launch, "-m", "tests.training.shared_steps", str(folder), str(STOPPED_AT)],
        check=True,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
        timeout=300,
    )
    told = [json.loads((folder / f"losses_{rank}.json").read_text()) for rank in range(2)]
    return folder, told


@pytest.fixture(scope="module")
def resumed(together):
    return curves(together[0], ALONE)


@pytest.mark.slow
def test_two_ranks_have_the_loss_curves_of_one_and_go_on_on_one(alone, together, resumed):
    (_, straight), (_, (first, second)) = alone, together
    assert first == second  # each knows the loss of the whole batch
    assert sorted(map(len, first.values())) == [STOPPED_AT, STOPPED_AT, STEPS, STEPS, STEPS]
    assert straight.keys() == first.keys()
    for name, losses in straight.items():
        assert len(losses) == STEPS
        assert first[name] + resumed.get(name, []) == pytest.approx(losses, rel=1e-3), name


@pytest.mark.slow
@pytest.mark.usefixtures("resumed")
def test_two_ranks_and_then_one_end_at_the_weights_of_one(alone, together):
    for name in ("backbone.pt", "language_sentences.pt"):
        wanted, found = (load_checkpoint(folder / name) for folder in (alone[0], together[0]))
        assert found["step"] == wanted["step"]
        part = "vit" if name == "backbone.pt" else "model"
        pairs = [(found[part][key], values) for key, values in wanted[part].items()]
        apart = sum(float((ours - theirs).square().sum()) for ours, theirs in pairs) ** 0.5
        size = sum(float(theirs.square().sum()) for _, theirs in pairs) ** 0.5
        assert apart <= MOST_APART * size, name


def test_shares_are_a_batch_and_nothing_twice():
    shares = [Ranks(rank, 3).share(list(range(12))) for rank in range(3)]
    assert sorted(sum(shares, [])) == list(range(12))
    assert {len(share) for share in shares} == {4}


def test_a_batch_that_does_not_divide_is_refused():
    with pytest.raises(UsageError) as caught:
        Ranks(0, 3).refuse_uneven(9, 32)
    assert str(caught.value) == (
        "A batch of 32 cannot be shared evenly by 3 processes; start a number that divides it."
    )


def test_the_device_is_cuda_where_there_is_one_and_each_process_has_its_own(monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 2)
    monkeypatch.delenv("LOCAL_RANK", raising=False)
    assert device_named(None) == device_named("cuda") == "cuda"
    assert device_named("cpu") == "cpu"
    monkeypatch.setenv("LOCAL_RANK", "1")
    assert device_named(None, 1) == "cuda:1"
    assert Ranks(1, 2, "cuda:1").kind == "cuda"
    with pytest.raises(MissingDependency) as caught:
        device_named("cuda", 2)
    assert str(caught.value) == (
        "2 GPUs were found by torch, expected at least 3; start fewer processes, or choose "
        "--device cpu."
    )
    with pytest.raises(UsageError, match="There is no device 'tpu'; did you mean 'cpu'?"):
        device_named("tpu")
