"""The forms of a data set's files, read by the libraries they are for."""

import json

import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.simulation import shard_forms
from geotlm_lm.simulation.dataset import read_shard, write_dataset
from geotlm_lm.simulation.shard_forms import FORMS, told_by

OBJECTS = ("block", "cloth_coarse")
GIVEN = {"seed": 1, "objects": OBJECTS, "preset": "draft"}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """The same three clips in every form."""
    pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra track")
    root = tmp_path_factory.mktemp("forms")
    return {form: write_dataset(root / form, 3, form=form, **GIVEN) for form in FORMS}


@pytest.fixture(scope="module")
def truth(folders):
    return read_shard(folders["npz"] / "shard-00000.npz")


def test_webdataset_reads_every_clip_as_the_archive_holds_it(folders, truth):
    webdataset = pytest.importorskip("webdataset", reason="needs webdataset, of the extra dev")
    arrays, labels = truth
    url = str(folders["webdataset"] / "shard-00000.tar")
    clips = list(webdataset.WebDataset(url, shardshuffle=False).decode("rgb8"))
    assert [clip["__key__"] for clip in clips] == ["000000000", "000000001", "000000002"]
    for place, clip in enumerate(clips):
        frames = np.stack([clip[f"frame_{number}.png"] for number in range(4)])
        assert np.array_equal(frames, arrays["frames"][place])
        assert np.array_equal(clip["background.png"], arrays["backgrounds"][place])
        assert np.array_equal(clip["displacement_px.npy"], arrays["displacement_px"][place])
        assert clip["json"]["label"]["motion"] == labels[place].motion
        assert clip["json"]["object_name"] == arrays["object_names"][place]


def test_datasets_reads_every_clip_as_the_archive_holds_it(folders, truth, tmp_path):
    datasets = pytest.importorskip("datasets", reason="needs datasets, of the extra dev")
    arrays, labels = truth
    found = datasets.load_dataset(
        str(folders["huggingface"]), split="train", cache_dir=str(tmp_path)
    )
    assert len(found) == 3
    for place, clip in enumerate(found):
        frames = np.stack([np.asarray(clip[f"frame_{number}"]) for number in range(4)])
        assert np.array_equal(frames, arrays["frames"][place])
        assert np.array_equal(clip["contact"], arrays["contact"][place])
        assert clip["motion"] == labels[place].motion
        assert clip["rotation_deg"] == pytest.approx(labels[place].rotation_deg)
        assert json.loads(clip["label"]) == labels[place].to_dict()


@pytest.mark.parametrize("form", ["webdataset", "huggingface"])
def test_the_card_counts_the_same_and_says_which_files_are_data(folders, form):
    card, plain = ((folders[one] / "README.md").read_text() for one in (form, "npz"))
    assert f'data_files: "shard-*{FORMS[form].suffix}"' in card
    assert FORMS[form].about in card
    assert [x for x in plain.splitlines() if x not in card.splitlines()] == []
    assert "configs:" not in plain


@pytest.mark.parametrize("form", ["webdataset", "huggingface"])
def test_a_stopped_run_ends_with_the_same_bytes_and_forms_are_not_mixed(folders, form, tmp_path):
    out = write_dataset(tmp_path / "out", 3, form=form, **GIVEN)
    name = f"shard-00000{FORMS[form].suffix}"
    (out / name).write_bytes((out / name).read_bytes()[:5000])
    write_dataset(out, 3, form=form, **GIVEN)
    assert (out / name).read_bytes() == (folders[form] / name).read_bytes()
    with pytest.raises(UsageError, match="other objects or settings"):
        write_dataset(out, 3, **GIVEN)


def test_a_damaged_shard_tells_nothing(tmp_path):
    for form, kind in FORMS.items():
        path = tmp_path / f"shard{kind.suffix}"
        assert told_by(path, form) is None
        path.write_bytes(b"half of it")
        assert told_by(path, form) is None


def test_labels_alone_have_no_pictures(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, of the extra track")
    out = write_dataset(tmp_path / "out", 1, form="huggingface", with_frames=False, **GIVEN)
    with parquet.ParquetFile(out / "shard-00000.parquet") as file:
        names = set(file.schema_arrow.names)
    assert {"label", "displacement_px"} < names
    assert not any(name.startswith(("frame", "background")) for name in names)


def test_without_pyarrow_the_extra_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(shard_forms, "find_spec", lambda name: None)
    with pytest.raises(MissingDependency, match=r"written with pyarrow, .*'geotlm-lm\[track\]'"):
        write_dataset(tmp_path, 1, form="huggingface", **GIVEN)
