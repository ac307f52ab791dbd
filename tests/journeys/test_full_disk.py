"""Whatever is written onto a full disk: one sentence that names it, the old file, nothing else."""

import numpy as np
import pytest
import torch

from geotlm_lm.checkpoint import save_bundle
from geotlm_lm.core.errors import Unwritten
from geotlm_lm.core.record import RunRecord
from geotlm_lm.track.drawing import write_film
from geotlm_lm.track.export import Exported
from geotlm_lm.track.plot import write_plot
from geotlm_lm.track.rerun_log import log_clip, rerun_recording
from geotlm_lm.training.fit import save_checkpoint
from tests.cli.recorded_touch import CLIP
from tests.full_disk import full_disk
from tests.track.recordings import frame
from tests.track.tracks import happened, moving_track

TRACK = Exported(moving_track(np.zeros((9, 4)), [happened("turn", 2, 6, turn=20)]))
FRAMES = [(number, frame(seed=number)) for number in range(9)]


def save_rerun(path):
    with rerun_recording(path) as stream:
        log_clip(stream, CLIP)


WRITERS = {
    ".csv": lambda path: TRACK.save(path, {}),
    ".json": lambda path: TRACK.save(path, {}),
    ".parquet": lambda path: TRACK.save(path, {}),
    ".png": lambda path: write_plot(path, TRACK, in_frames=False),
    ".mp4": lambda path: write_film(path, TRACK, FRAMES, 25.0),
    ".rrd": save_rerun,
    ".pt": lambda path: save_checkpoint(path, {"weights": torch.zeros(900)}),
    ".record": lambda path: RunRecord("a", "b" * 900, 0, 1.0, {}).save(path),
}


@pytest.mark.parametrize("ending", WRITERS)
def test_a_file_that_does_not_fit_is_told_and_the_old_one_kept(tmp_path, ending, capfd):
    if ending == ".rrd":
        pytest.importorskip("rerun", reason="needs rerun-sdk, of the extra rerun")
    path = tmp_path / f"file{ending}"
    path.write_bytes(b"old")
    with full_disk(), pytest.raises(Unwritten) as caught:
        WRITERS[ending](path)
    assert str(caught.value).startswith(f"{path}")
    assert caught.value.exit_code == 2
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == b"old"
    assert capfd.readouterr().err == ""
    WRITERS[ending](path)  # and with room it is written
    assert path.stat().st_size > 600


def test_a_bundle_that_does_not_fit_leaves_no_part_of_a_file(bundle, tmp_path):
    with full_disk(), pytest.raises(Unwritten, match="^.*/perception.safetensors: cannot be"):
        save_bundle(tmp_path / "bundle", bundle)
    assert list((tmp_path / "bundle").iterdir()) == []
