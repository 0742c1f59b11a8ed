from pathlib import Path

import pytest

from snapmap.config import load_device

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def root():
    return ROOT


@pytest.fixture(scope="session")
def handout():
    """The handout's device."""
    return load_device(ROOT / "config" / "config.yaml")
