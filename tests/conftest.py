import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from varied import share_of_limit

from snapmap.config.devices import load_device
from snapmap.solver.kept import forget

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def root():
    return ROOT


@pytest.fixture(scope="session")
def workflow_text():
    """The text of the workflow: the Snakefile and all that it includes."""
    paths = [ROOT / "Snakefile", *sorted((ROOT / "workflow" / "rules").glob("*.smk"))]
    return "\n".join(path.read_text(encoding="utf-8") for path in paths)


@pytest.fixture(scope="session")
def python(root):
    """Run a program that finds the package in a Python of its own; gives what it says."""

    def run(program, *words, options=(), cwd=root):
        path = {"PYTHONPATH": str(root / "workflow" / "scripts"), "OPENBLAS_NUM_THREADS": "1"}
        command, env = [sys.executable, *options, "-c", program, *words], os.environ | path
        done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True)
        return done.stdout, done.stderr

    return run


@pytest.fixture
def fix_step(monkeypatch):
    """Give all models that are built one step, a share of their limit, as `in_steps` does."""

    def fix(share):
        forget()
        monkeypatch.setattr("snapmap.solver.models.steps_of", share_of_limit(share))
        monkeypatch.setattr("snapmap.solver.steps.OF_LIMIT", share)

    yield fix
    forget()


@pytest.fixture(scope="session")
def handout():
    """The handout's device."""
    return load_device(ROOT / "config" / "config.yaml")


@pytest.fixture
def paper(monkeypatch):
    """The figures' own style, not laid out before a figure is drawn; a warning is a fault."""
    from snapmap.figures import style

    monkeypatch.setattr(style, "lay_out", lambda figure: figure.set_layout_engine("none"))
    with style.paper(), warnings.catch_warnings(action="error"):
        yield


@pytest.fixture
def sketch(paper, monkeypatch):
    """As `paper`, with legends as they come: test_own_axes.py is on their size and place."""
    from snapmap.figures import style

    plain = lambda figure, keys, ncols, given: figure.legend(handles=keys, **given)  # noqa: E731
    monkeypatch.setattr(style, "_legend_below", plain)
