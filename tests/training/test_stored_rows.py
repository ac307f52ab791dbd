import numpy as np
import pytest

from geotlm_lm.training.stored_rows import StoredPart, StoredRows


@pytest.fixture
def stored(tmp_path):
    """Two files of four rows, of which three of the second count; and what they hold."""
    values = np.arange(8 * 2 * 3).reshape(8, 2, 3).astype(np.float16)
    paths = [tmp_path / f"{index}.npz" for index in range(2)]
    for path, rows in zip(paths, (values[:4], values[4:]), strict=True):
        np.savez(path, other=np.zeros(5), rows=rows)
    parts = [StoredPart.of(path, "rows", most) for path, most in zip(paths, (9, 3), strict=True)]
    return StoredRows(parts), values[:7]


@pytest.mark.parametrize(
    "rows", [slice(None), slice(2, 6), slice(5, 99), np.array([6, 0, 3, 4, 3]), np.array([], int)]
)
def test_rows_are_those_of_the_arrays_one_behind_the_other(stored, rows):
    found, values = stored
    assert len(found) == 7
    assert found[rows].dtype == values.dtype
    np.testing.assert_array_equal(found[rows], values[rows])


def test_it_is_an_array_to_numpy(stored):
    np.testing.assert_array_equal(np.concatenate([stored[0]]), stored[1])


def test_a_row_that_does_not_count_is_not_there(stored):
    with pytest.raises(IndexError):
        stored[0][np.array([7])]


def test_rows_without_a_place_of_their_own_are_refused(tmp_path):
    np.savez_compressed(tmp_path / "a.npz", rows=np.zeros((4, 2)))
    with pytest.raises(ValueError, match="rows is compressed"):
        StoredPart.of(tmp_path / "a.npz", "rows", 4)
    np.savez(tmp_path / "b.npz", rows=np.zeros((4, 2)).T)
    with pytest.raises(ValueError, match="rows is laid out column by column"):
        StoredPart.of(tmp_path / "b.npz", "rows", 4)
