import pytest

from snapmap.study.study import Study


@pytest.fixture(scope="session")
def study(handout):
    """The handout's device by three cosines, to 300 us after a shock."""
    model = {"name": "cosines", "modes": 3}
    return Study(handout, model=model, horizon=300.0)
