"""Small products are computed in one thread, and the process's own counts come back."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest
import torch
from threadpoolctl import threadpool_limits

from geotlm_lm.core.process import _blas, in_one_thread


def blas_threads() -> set[int]:
    """Return the threads of numpy's products; scipy has a library of its own."""
    return {pool["num_threads"] for pool in _blas().info()}


@pytest.fixture
def two_threads():
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    with threadpool_limits(2, user_api="blas"):
        yield
    torch.set_num_threads(before)


def broken_off() -> None:
    with in_one_thread():
        assert (torch.get_num_threads(), blas_threads()) == (1, {1})
        raise ValueError("broken off")


def test_inside_numpy_and_torch_have_one_thread_and_afterwards_as_many_as_before(two_threads):
    with in_one_thread():
        with pytest.raises(ValueError, match="broken off"):
            broken_off()
        assert (torch.get_num_threads(), blas_threads()) == (1, {1})
    assert (torch.get_num_threads(), blas_threads()) == (2, {2})


def test_who_ends_first_leaves_the_others_their_one_thread(two_threads):
    both_in, one_out = Barrier(2, timeout=60), Barrier(2, timeout=60)

    def early() -> None:
        with in_one_thread():
            both_in.wait()
        one_out.wait()

    def late() -> set[int]:
        with in_one_thread():
            both_in.wait()
            one_out.wait()
            return blas_threads()

    with ThreadPoolExecutor(2) as pool:
        first, second = pool.submit(early), pool.submit(late)
        first.result()
        assert second.result() == {1}
    assert blas_threads() == {2}
