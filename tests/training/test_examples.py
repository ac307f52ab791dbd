"""Laws: the same examples whatever the number of workers, and after a kill."""

import numpy as np
import pytest

from geotlm_lm.core.seeding import generator_for
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.training import examples
from geotlm_lm.training.examples import (
    ExampleSet,
    _frame_order,
    read_examples,
    simulate_examples,
)
from tests.training.in_process import InProcess


@pytest.fixture
def _small_chunks(monkeypatch):
    monkeypatch.setattr(examples, "CHUNK_CLIPS", 4)
    # Worker processes would import the module afresh, with its own chunk size.
    monkeypatch.setattr(examples, "ProcessPoolExecutor", InProcess)


def made_in(folder):
    wanted = ExampleSet("check", 8, TRAINING_OBJECTS[:3])
    simulate_examples(folder, [wanted], seed=5, workers=1)
    return read_examples(folder, wanted)


@pytest.mark.usefixtures("_small_chunks")
def test_a_missing_chunk_is_made_again_byte_for_byte(tmp_path):
    first = made_in(tmp_path)
    (tmp_path / "check_0001.npz").unlink()
    again = made_in(tmp_path)
    assert np.array_equal(first.inputs, again.inputs)
    assert np.array_equal(first.displacement_px, again.displacement_px)
    assert first.labels == again.labels
    assert len(first) == 8
    assert set(first.objects) <= set(TRAINING_OBJECTS[:3])


def test_four_frames_run_forwards_or_form_a_pair_one_or_two_frames_apart():
    orders = {tuple(_frame_order(generator_for(0, index))) for index in range(200)}
    assert orders == {(0, 1, 2, 3), (0, 0, 1, 1), (0, 0, 2, 2)}
