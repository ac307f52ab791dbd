"""Names that are not UTF-8, or that libraries take for more than a name, are read as any other."""

import os
import shutil

import numpy as np
import pytest
from PIL import Image

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.files import plain_name
from geotlm_lm.recordings.read import each_frame, read_clip
from geotlm_lm.recordings.streams import open_source
from tests.recordings.bag_files import MCAP, SQLITE, even_ns, first_bag, raw, raw_bag
from tests.recordings.test_read import write_gif, write_images, write_video
from tests.recordings.test_video_forms import FEW

NAMES = (os.fsdecode(b"m\xe9"), "12:30", "grip#1", "50%41", "which?")


def stack(path):
    first, *others = map(Image.fromarray, FEW)
    first.save(path, save_all=True, append_images=others)


def folder(path):
    path.mkdir()
    write_images(path, FEW)


def bag_file(path):
    raw_bag(path.parent / "run", FEW, storage=MCAP if path.suffix == ".mcap" else SQLITE)
    [stored] = (path.parent / "run").glob(f"*{path.suffix}")
    shutil.move(stored, path)


FORMS = {
    ".npy": lambda path: np.save(path, FEW),
    ".npz": lambda path: np.savez(path, frames=FEW),
    ".avi": lambda path: write_video(path, FEW),
    ".gif": lambda path: write_gif(path, FEW, 40),
    ".tif": stack,
    ".mcap": bag_file,
    ".db3": bag_file,
    ".bag": lambda path: first_bag(
        path, {"/gel": [raw(*pair) for pair in zip(FEW, even_ns(5), strict=True)]}
    ),
    "": folder,
}


@pytest.mark.parametrize("ending", FORMS)
@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_a_recording_is_read_whatever_its_name(tmp_path, monkeypatch, name, ending):
    FORMS[ending](tmp_path / f"clip{ending}")
    home = tmp_path / name
    home.mkdir()
    os.rename(tmp_path / f"clip{ending}", home / f"{name}{ending}")
    monkeypatch.chdir(home)
    for path in (f"{name}{ending}", str(home / f"{name}{ending}")):
        assert np.array_equal(read_clip(path).frames, FEW)
        assert np.array_equal(np.stack([frame.image for frame in open_source(path)]), FEW)
        assert len(list(each_frame(read_clip(path)))) == len(FEW)


@pytest.mark.parametrize("parts", [1, 2])
@pytest.mark.parametrize("name", NAMES[2:], ids=ascii)
def test_the_folder_of_a_bag_too_and_no_file_is_left_in_it(tmp_path, name, parts):
    folder = raw_bag(tmp_path / "run", FEW, storage=SQLITE)
    about = (folder / "metadata.yaml").read_text()
    (folder / "metadata.yaml").write_text(about.replace("run.db3", f"{name}_0.db3"))
    for part in range(parts):
        shutil.copy(folder / "run.db3", folder / f"{name}_{part}.db3")
    (folder / "run.db3").unlink()
    before = sorted(folder.iterdir())
    if parts == 1:
        assert np.array_equal(read_clip(folder).frames, FEW)
    else:
        with pytest.raises(UnreadableClip, match="one by one"):
            read_clip(folder)
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_what_is_written_to_a_plain_name_appears_at_the_path(tmp_path, name):
    path = tmp_path / name / f"{name}.mp4"
    path.parent.mkdir()
    with plain_name(path) as plain:
        plain.encode()
        assert plain.endswith(".mp4")
        with open(plain, "wb") as stream:
            stream.write(b"written")
    assert path.read_bytes() == b"written"
    assert os.listdir(path.parent) == [path.name]
