"""What lies in a file of tokens is what the backbone, the simulator and the references say."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.released import load_encoder
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import ROTATIONS
from geotlm_lm.experiments import protocol_clips
from geotlm_lm.experiments.protocol_clips import (
    ProtocolClips,
    backbone_digest,
    cache_folder,
    read_or_encode,
    source_digest,
)
from geotlm_lm.probe.curl import curl_features
from geotlm_lm.probe.rigid_flow import RigidFlow
from tests.backbone.small_files import write_small
from tests.experiments.plain_backbone import PlainBackbone

WANTED = ProtocolClips(("key", "cable"), clips=3, seed=5)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tokens")
    return folder, read_or_encode(folder, PlainBackbone(), WANTED, "rotation")


@pytest.fixture(scope="module")
def simulated():
    """The readable clips of the first object, simulated on their own."""
    made = protocol_clips._series(WANTED, "rotation", "key")
    readable = (one for one in made if one.label.is_readable)
    return [next(readable) for _ in range(WANTED.clips)]


def test_tokens_truths_and_references_are_those_of_the_clips(kept, simulated):
    clips, found = [made.clip for made in simulated], kept[1]
    tokens = PlainBackbone().encode(clips)
    assert torch.equal(found.data[4].tokens.patches[:3], tokens.patches.half())
    assert torch.equal(found.data[4].tokens.global_token[:3], tokens.global_token)
    assert found.truths[:3] == tuple(made.label.motion for made in simulated)
    assert found.flow[:3] == tuple(RigidFlow().predict(clip, ROTATIONS) for clip in clips)
    np.testing.assert_array_equal(found.curl[:3], [curl_features(clip) for clip in clips])
    assert found.objects == ("key",) * 3 + ("cable",) * 3


def test_two_frames_are_the_first_and_the_last_twice_each(kept, simulated):
    pairs = [made.clip.select((0, 0, 3, 3)) for made in simulated]
    expected = PlainBackbone().encode(pairs).patches.half()
    assert torch.equal(kept[1].data[2].tokens.patches[:3], expected)


def test_the_true_change_is_the_simulators_displacement_between_the_bins(kept, simulated):
    # The plain backbone's grid is the simulator's own: nothing is cut or blended.
    moved, contact = (
        np.stack([getattr(made, name) for made in simulated])
        for name in ("displacement_px", "contact")
    )
    always = (contact > 0.5).all(axis=1)
    assert always.any()
    four = kept[1].data[4].shear_change[:3].numpy()
    expected = moved[:, 2:].mean(axis=1) - moved[:, :2].mean(axis=1)
    np.testing.assert_allclose(four[always], expected[always], atol=1e-3)
    two = kept[1].data[2].shear_change[:3].numpy()
    np.testing.assert_allclose(two[always], (moved[:, 3] - moved[:, 0])[always], atol=1e-3)
    np.testing.assert_allclose(kept[1].data[4].contact[:3], contact.mean(axis=1), atol=1e-6)


def test_files_that_are_there_are_read_and_nothing_is_encoded(kept):
    folder, first = kept
    backbone = PlainBackbone()
    again = read_or_encode(folder, backbone, WANTED, "rotation")
    assert backbone.encoded == 0
    assert torch.equal(again.data[4].tokens.patches, first.data[4].tokens.patches)
    assert (again.flow, again.objects) == (first.flow, first.objects)
    assert (again.unreadable, again.seconds) == (first.unreadable, first.seconds)


def test_a_stopped_run_continues_with_the_object_it_was_at(kept, tmp_path, monkeypatch):
    backbone, encode = PlainBackbone(), PlainBackbone.encode

    def interrupted(self, clips):
        if self.encoded >= 2 * WANTED.clips:  # the first object, four frames and two
            raise KeyboardInterrupt
        return encode(self, clips)

    with monkeypatch.context() as patch:
        patch.setattr(PlainBackbone, "encode", interrupted)
        with pytest.raises(KeyboardInterrupt):
            read_or_encode(tmp_path, backbone, WANTED, "rotation")
    assert [path.name for path in tmp_path.iterdir()] == ["rotation-key.npz"]
    backbone = PlainBackbone()
    resumed = read_or_encode(tmp_path, backbone, WANTED, "rotation")
    assert backbone.encoded == 2 * WANTED.clips
    assert torch.equal(resumed.data[4].tokens.patches, kept[1].data[4].tokens.patches)


def test_files_hold_no_pickles(kept):
    for path in kept[0].glob("*.npz"):
        with np.load(path, allow_pickle=False) as stored:
            assert all(stored[name].dtype.kind in "fib" for name in stored.files)


def test_another_backbone_other_clips_or_other_code_have_a_folder_of_their_own(
    tmp_path, monkeypatch
):
    def place(gain=1.0, **changes):
        return cache_folder(tmp_path, PlainBackbone(gain), replace(WANTED, **changes))

    places = [place(), place(gain=2.0), place(clips=4), place(seed=6), place(objects=("key",))]
    assert len(set(places)) == len(places)
    assert place() == places[0]
    monkeypatch.setattr(protocol_clips, "source_digest", lambda *parts: "other")
    assert place() not in places


def test_the_digest_of_code_follows_what_is_written_in_it(tmp_path, monkeypatch):
    package = tmp_path / "package"
    (package / "room").mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "room" / "a.py").write_text("x = 1\n")
    monkeypatch.setattr(protocol_clips.geotlm_lm, "__file__", str(package / "__init__.py"))
    before = source_digest("room"), source_digest("room/a.py")
    assert (source_digest("room"), source_digest("room/a.py")) == before
    (package / "room" / "a.py").write_text("x = 2\n")
    assert source_digest("room") != before[0]
    assert source_digest("room/a.py") != before[1]


def test_the_sources_of_what_is_kept_exist():
    for part in protocol_clips.SOURCES:
        assert source_digest(part) != source_digest()


def test_a_grid_without_a_view_has_no_truth(tmp_path):
    one = replace(WANTED, objects=("key",), clips=2)
    found = read_or_encode(tmp_path, PlainBackbone(has_view=False), one, "sliding")
    assert not found.has_truth
    assert found.data[4].shear_change is None


def test_a_released_encoder_is_kept_under_its_own_digest(tmp_path):
    path = write_small("anytouch2", tmp_path / "file")
    encoder, same, other = (load_encoder(path, heads=heads) for heads in (2, 2, 3))
    one = replace(WANTED, objects=("key",), clips=2)
    folder = cache_folder(tmp_path, encoder, one)
    assert backbone_digest(encoder) == backbone_digest(same)
    assert backbone_digest(encoder) != backbone_digest(other)  # the same weights, read otherwise
    assert folder.name.startswith(f"tokens-{backbone_digest(encoder)}-")
    found = read_or_encode(folder, encoder, one, "rotation")
    assert found.data[4].tokens.patches.shape == (2, *encoder.patch_shape)
    assert not found.has_truth  # its grid is 3 x 3


def test_too_few_readable_clips_are_refused(tmp_path, monkeypatch):
    def unreadable(*arguments, **more):
        for made in protocol_clips_series(*arguments, **more):
            yield replace(made, trace_until=lambda last: Blank())

    class Blank:
        def shows(self, motion):
            return False

    protocol_clips_series = protocol_clips.simulate_series
    monkeypatch.setattr(protocol_clips, "simulate_series", unreadable)
    one = replace(WANTED, objects=("key",), clips=1)
    with pytest.raises(UsageError) as caught:
        read_or_encode(tmp_path, PlainBackbone(), one, "rotation")
    assert str(caught.value) == (
        "key: 0 readable clips of rotation among 6 simulated ones, expected 1; ask for more clips, "
        "or leave the object out."
    )
    assert not list(tmp_path.iterdir())


def test_tokens_beyond_half_precision_are_refused(tmp_path):
    one = replace(WANTED, objects=("key",), clips=1)
    with pytest.raises(UsageError, match="were found, expected below 65504; the weights are not"):
        read_or_encode(tmp_path, PlainBackbone(gain=1e9), one, "rotation")
