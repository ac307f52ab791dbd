import pytest

from tests.tiny_bundle import tiny_bundle


@pytest.fixture(scope="session")
def bundle():
    return tiny_bundle()
