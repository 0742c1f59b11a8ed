"""What an application can add to a study: the methods of `Application`, which add nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import numpy as np

    from ..config.study import Config
    from ..device.device import Device
    from ..pulse.shocks import Shocks
    from ..solver.cells import Cells, Observations
    from ..solver.models import Follows
    from ..solver.settings import Run
    from ..study.study import Study
    from .requirements.verdict import Verdict
else:
    Config = Any  # itself it imports the applications

Files = Mapping[str, str | list[str]]
"""Path, or paths, of files by name."""
Figures = Mapping[str, Mapping[str, Any]]
"""Arguments of `draw`, in plain values, by the name of a figure."""
HALF_OF_CORES = 0
"""Threads of a job that leaves the other half of the cores to jobs beside it."""


class Mark(NamedTuple):
    """A shock that maps of cells show.

    f0: Hz; pushed: section of the pulse, direction, and start of the beam, of each way in which the
    shock counts
    """

    name: str
    f0: float
    N: float
    pushed: list[tuple[Mapping, str, str]]


class Application:
    """One capability beside the core: keys of a config, functions, files and figures.

    The `__init__.py` of its folder has the one instance, `application`. Methods import what they
    need, as a job of cells does without xarray and Matplotlib.

    Attributes
    ----------
    rule, message
        name and message of the job that calls `run`; no rule if another job does
    quick
        whether the job of the thresholds calls `run`, and the job of the study `draw`, as a job of
        its own would take longer to start than to run
    threads, megabytes, priority
        resources of the job; threads may be HALF_OF_CORES
    part
        heading of its figures in the report; their caption is caption.rst
    saved_in, endings
        folder of its figures, and the endings of the files that each of them is
    size
        height of its figures, in, and over how many columns of a page they go
    """

    rule: str = ""
    message: str = ""
    quick: bool = False
    threads: int = 1
    megabytes: int = 1000
    priority: int = 45
    part: str = ""
    saved_in: str = "results/figures"
    endings: tuple[str, ...] = ("png", "pdf")
    size: tuple[float, int] = (3.6, 2)

    # What a config asks of it.

    def section(self) -> tuple[Any, str] | None:
        """Type and sentence of its key in a config, the name of its folder; None for no key."""

    def kinds(self) -> Mapping[str, Any]:
        """Records of requirements, by the key that only they have."""
        return {}

    def request(self, section: Any, study: Config, document: Any) -> Any:
        """Its section as `study.requests` holds it; false for no request.

        Raises ValueError, one line, for what the study cannot have.
        """

    def files(self, study: Config) -> Mapping[str, str]:
        """SHA-256 of the files that its section names, by path."""
        return {}

    def refuse(self, study: Config) -> None:
        """Raise ValueError, one line, for what a few runs show that its job cannot make.

        Called once, before the first job.
        """

    def doubts(self, study: Config) -> Sequence[str]:
        """Lines about values that are probably mistakes."""
        return ()

    def records(self, study: Config) -> Sequence[tuple[Shocks, float, str]]:
        """Recorded shocks that its section names, each with f0 (Hz) and start."""
        return ()

    def marks(self, study: Config) -> Sequence[Mark]:
        """Shocks that maps of cells show."""
        return ()

    def alone(self, study: Config) -> Sequence[float]:
        """f0 (Hz) of the single cells that it simulates beside the grid."""
        return ()

    def counts(self, study: Config) -> Mapping[str, int]:
        """How much it computes, by the words of `workflow.plan.RUNS`."""
        return {}

    # What it makes.

    def outputs(self, study: Config) -> Files:
        """Files that it makes; empty if the study requests none."""
        return {}

    def inputs(self, study: Config) -> Files:
        """Results that it reads."""
        return {}

    def params(self, study: Config) -> Mapping[str, Any]:
        """Plain values on which its files depend, beside device, pulse and model."""
        return {}

    def run(self, *args: Any, **kwargs: Any) -> None:
        """Make the files.

        An application takes `study`, and NAME_path (NAME_paths of several) of its inputs and
        outputs; `path` is the first output.
        """
        raise NotImplementedError

    # What it adds to files of others.

    def observe(
        self, model: Follows, cells: Cells, observed: Observations, settings: Run
    ) -> Mapping[str, np.ndarray]:
        """Floats that it adds to the cells of a cube, by name."""
        return {}

    def in_history(self, model: Follows, cells: Cells, settings: Run) -> Mapping[str, Any]:
        """Attributes that it adds to the history of a cell."""
        return {}

    def in_statics(
        self, device: Device, first: float, displacement: np.ndarray, force: np.ndarray
    ) -> Mapping[str, Any]:
        """Attributes that it adds to statics.

        Parameters
        ----------
        first
            w(L/2) at rest, um
        displacement, force
            of the midpoint, um and uN, along the path of a beam that is pushed
        """
        return {}

    def in_datasheet(self, study: Study, verdicts: Sequence[Verdict]) -> Sequence[str]:
        """Tables that it adds to a data sheet; verdicts: worst first."""
        return ()

    # What it draws.

    def figures(self, study: Config) -> Figures:
        """Its figures; empty if there is none to draw."""
        return {}

    def drawn_from(self, study: Config) -> Files:
        """Files that `draw` reads, by default its outputs; nothing is drawn from none."""
        return self.outputs(study)

    def drawn(self, study: Config) -> Figures:
        """The figures that a run draws."""
        return self.figures(study) if self.drawn_from(study) else {}

    def draw(self, figures: Figures, folder: str, files: Files) -> None:
        """Draw and save the figures, all from one file, or each from a file of its own.

        The function `draw` of the folder's `figure.py` takes an empty figure, the dataset, and what
        `figures` says of it by name.
        files: as `drawn_from` names them
        """
        from ..figures import style
        from ..study.variables import open_whole

        draw = import_module(f"{type(self).__module__}.figure").draw
        (paths,) = files.values()
        paths = [paths] * len(figures) if isinstance(paths, str) else paths
        for (name, how), path in zip(figures.items(), paths, strict=True):
            with (
                open_whole(path) as data,
                style.saved(f"{folder}/{name}", data.attrs, *self.size) as figure,
            ):
                draw(figure, data, **how)
