"""Small examples for the training tests."""

import pytest

from tests.training.shared_steps import random_examples


@pytest.fixture(scope="session")
def tiny_examples():
    return random_examples()
