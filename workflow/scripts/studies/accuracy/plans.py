"""What is compared: numbers of modes, steps, contacts and horizons, in full or quickly."""

from typing import NamedTuple


class Refinement(NamedTuple):
    """Of a converged run.

    cosines: of the run itself, and fewer to estimate its error
    meshes, modes: the same of the other discretisation: elements, and modes kept; () for none
    """

    cosines: tuple[int, int]
    meshes: tuple[int, ...] = ()
    modes: tuple[int, ...] = ()


class Plan(NamedTuple):
    """What is compared.

    elements, cosines: numbers of them; all modes are kept, but of elements at most `most_modes`
    steps: fractions of the stability limit, the finest first
    penalties: multiples of the device's contact, beside hard contact
    horizons: multiples of the settings', the longest last
    converged, hard: refinement of the converged run, and of that with hard contact
    judges: cosines of the models that choose the thresholds: to scan, to decide and to doubt
    side: cells of the map along N and f0
    """

    elements: tuple[int, ...]
    most_modes: int
    cosines: tuple[int, ...]
    steps: tuple[float, ...]
    penalties: tuple[float, ...]
    horizons: tuple[float, ...]
    converged: Refinement
    hard: Refinement
    judges: tuple[int, int, int]
    side: int


PLANS = {
    # All 39 modes of 20 elements would take a minute for each map.
    "full": Plan(
        elements=(3, 5, 10, 20),
        most_modes=19,
        cosines=(2, 3, 4, 5, 6, 8),
        steps=(0.1, 0.2, 0.4, 0.6, 0.8, 1.0),
        penalties=(1, 10, 100),
        horizons=(0, 0.3, 1, 3),
        converged=Refinement((16, 12), (20, 10), (12, 8)),
        hard=Refinement((12, 8), (20, 10), (12, 8)),
        judges=(3, 8, 5),
        side=24,
    ),
    # Three numbers of modes, 3, 5 and 9: for each a kernel is compiled.
    "quick": Plan(
        elements=(3, 5),
        most_modes=9,
        cosines=(3, 5),
        steps=(0.4, 0.8),
        penalties=(1, 10, 100),
        horizons=(0, 1),
        converged=Refinement((9, 5)),
        hard=Refinement((5, 3)),
        judges=(3, 5, 3),
        side=16,
    ),
}
