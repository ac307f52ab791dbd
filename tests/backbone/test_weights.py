"""Files others made: read without running anything, or refused in one sentence."""

import argparse
import collections
import enum
import functools
import pathlib
import pickle
import sys
import types

import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from geotlm_lm.backbone.weights import read_tensors
from geotlm_lm.core.errors import IncompatibleWeights

TENSORS = {"a.weight": torch.arange(6.0).view(2, 3), "b": torch.ones(4, dtype=torch.bfloat16)}


def same(found):
    return found.keys() == TENSORS.keys() and all(
        torch.equal(found[name], value) and found[name].dtype == value.dtype
        for name, value in TENSORS.items()
    )


def refusal(path):
    with pytest.raises(IncompatibleWeights) as caught:
        read_tensors(path)
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(str(path))
    return text.removeprefix(f"{path}: ")


def test_no_header_of_safetensors_is_taken_for_a_pickle(tmp_path):
    # The header's length comes first; 0x80, as 128 or 384, is how a pickle begins.
    for padding in range(0, 264, 8):
        save_file(TENSORS, tmp_path / "weights", metadata={"note": "x" * padding})
        assert same(read_tensors(tmp_path / "weights"))


@pytest.mark.parametrize(
    ("level", "wrapper"), [(None, ""), ("model", "module."), ("state_dict", "_orig_mod.")]
)
def test_pickles_are_read_with_and_without_a_level_and_a_wrapper(tmp_path, level, wrapper):
    named = {f"{wrapper}{name}": value for name, value in TENSORS.items()}
    stored = named if level is None else {level: named, "epoch": 3}
    torch.save(stored, tmp_path / "checkpoint.pth")
    assert same(read_tensors(tmp_path / "checkpoint.pth"))


class Mode(enum.Enum):
    MIN = "min"


@pytest.fixture
def foreign_module():
    """A module of classes that exist while a file is written and are gone when it is read."""
    module = types.ModuleType("gone_from_here")

    class Scheduler:
        def __init__(self, optimiser):
            self.optimiser, self.history = optimiser, collections.defaultdict(dict, {1: {2: 3}})

    class Reduced:
        def __reduce__(self):
            return type(self), ()

    for kind in (Scheduler, Reduced):
        kind.__module__, kind.__qualname__ = module.__name__, kind.__name__
        setattr(module, kind.__name__, kind)
    sys.modules[module.__name__] = module
    yield module
    sys.modules.pop(module.__name__, None)


def test_objects_of_classes_that_are_not_installed_are_read_over(tmp_path, foreign_module):
    weight = torch.nn.Parameter(torch.ones(2))
    optimiser = torch.optim.AdamW([weight])
    weight.sum().backward()
    optimiser.step()  # fills the optimiser's defaultdict
    stored = {
        "state_dict": TENSORS,
        "args": argparse.Namespace(rate=0.1),
        "scheduler": foreign_module.Scheduler(optimiser),
        "metrics": {"best": np.float64(0.5), "history": np.arange(3), "mode": Mode.MIN},
        "schedule": functools.partial(foreign_module.Scheduler, 1),
        "window": collections.deque([1, 2], maxlen=3),
        "counts": collections.Counter("aab"),
        "where": [pathlib.Path("runs"), slice(0, 2), frozenset({1}), complex(1, 2), b"x"],
        "callbacks": {foreign_module.Scheduler: {"best": 1.0}, "other": foreign_module.Reduced()},
    }
    torch.save(stored, tmp_path / "training.ckpt")
    del sys.modules["gone_from_here"]
    assert same(read_tensors(tmp_path / "training.ckpt"))


class Evil:
    def __init__(self, function, *arguments):
        self.call = function, arguments

    def __reduce__(self):
        return self.call


ATTACKS = {
    "builtins.exec": lambda mark: Evil(exec, f"open({str(mark)!r}, 'w')"),
    "builtins.eval": lambda mark: Evil(eval, f"open({str(mark)!r}, 'w')"),
    "io.open": lambda mark: Evil(open, str(mark), "w"),
    "subprocess.call": lambda mark: Evil(__import__("subprocess").call, ["touch", str(mark)]),
    "posix.system": lambda mark: Evil(__import__("os").system, f"touch {mark}"),
    "builtins.getattr": lambda mark: Evil(getattr, Evil(open, str(mark), "w"), "close"),
    "shutil.copy": lambda mark: Evil(__import__("shutil").copyfile, __file__, str(mark)),
}


@pytest.mark.parametrize("name", ATTACKS)
def test_a_pickle_that_would_run_code_is_refused_and_runs_none(tmp_path, name):
    mark, path = tmp_path / "was_run", tmp_path / "evil.pth"
    torch.save({"model": TENSORS, "extra": ATTACKS[name](mark)}, path)
    text = refusal(path)
    assert text.startswith(f"would call {name}")
    assert text.endswith(
        "when unpickled, which no weights need; do not open it, get the file from the encoder's "
        "authors."
    )
    assert not mark.exists()


def test_the_attacks_do_run_where_nothing_guards_them(tmp_path):
    # Without this the test above would also pass if the attacks were harmless.
    path = tmp_path / "evil.pth"
    for number, make in enumerate(ATTACKS.values()):
        mark = tmp_path / f"was_run_{number}"
        torch.save({"extra": make(mark)}, path)
        torch.load(path, weights_only=False)
        assert mark.exists()


@pytest.mark.parametrize("protocol", [2, 4])
def test_a_plain_pickle_that_would_run_code_is_refused_and_runs_none(tmp_path, protocol):
    mark, path = tmp_path / "was_run", tmp_path / "evil.pkl"
    path.write_bytes(pickle.dumps({"model": ATTACKS["builtins.exec"](mark)}, protocol=protocol))
    assert refusal(path).startswith("cannot be read safely")
    assert not mark.exists()


def test_a_name_of_another_package_is_never_imported(tmp_path, monkeypatch):
    (tmp_path / "bomb_package.py").write_text(
        "class Bomb:\n    pass\n\nopen(__file__ + '.imported', 'w')\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    import bomb_package

    torch.save({"model": TENSORS, "extra": bomb_package.Bomb()}, tmp_path / "file.pth")
    monkeypatch.delitem(sys.modules, "bomb_package")
    (tmp_path / "bomb_package.py.imported").unlink()
    assert same(read_tensors(tmp_path / "file.pth"))
    assert not (tmp_path / "bomb_package.py.imported").exists()


@pytest.mark.parametrize("kind", ["zip", "legacy", "safetensors"])
def test_a_file_cut_short_is_refused(tmp_path, kind):
    tensors = {f"layer.{i}.weight": torch.randn(40, 40) for i in range(4)}
    path = tmp_path / "weights"
    if kind == "safetensors":
        save_file(tensors, path)
    else:
        torch.save(tensors, path, _use_new_zipfile_serialization=kind == "zip")
    whole = path.read_bytes()
    for kept in (0.02, 0.3, 0.7, 0.99):
        path.write_bytes(whole[: int(kept * len(whole))])
        assert refusal(path).endswith("get the file the encoder's authors release.")


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"", "is empty"),
        (b"version https://git-lfs.github.com/spec/v1\noid", "is a Git LFS pointer, not the "),
        (b"<!DOCTYPE html><html>Sign in", "is a web page, as a download without access gives"),
        (b"\x89PNG\r\n\x1a\n----", "is neither a safetensors file nor a PyTorch checkpoint"),
    ],
)
def test_what_is_no_checkpoint_is_told_by_what_it_is(tmp_path, content, found):
    (tmp_path / "weights.pth").write_bytes(content)
    assert refusal(tmp_path / "weights.pth").startswith(found)


def test_a_missing_file_and_a_folder_are_told_apart(tmp_path):
    assert refusal(tmp_path / "none.pth") == (
        "cannot be read (No such file or directory); give the file the encoder's authors release."
    )
    with pytest.raises(IncompatibleWeights, match="is a folder, expected an encoder's file"):
        read_tensors(tmp_path)
