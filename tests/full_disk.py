"""A disk that takes no more, without a disk: the system refuses to let files grow."""

from contextlib import contextmanager

import pytest


@contextmanager
def full_disk(room=600):
    """Let no file of this process grow beyond some bytes inside; skip where that cannot be had."""
    resource = pytest.importorskip("resource", reason="needs limits on the size of files")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))  # Python ignores SIGXFSZ
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
