"""What several test files use."""

import os

import pytest


@pytest.fixture
def program() -> str:
    """Path of the command line to compare with."""
    path = os.environ.get("SUPERCOIL_PROGRAM")
    if not path:
        pytest.skip("SUPERCOIL_PROGRAM names no command line: python/check does")
    return path
