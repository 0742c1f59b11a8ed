"""A study as the rules of the workflow hand it to their scripts: plain values."""

from collections.abc import Mapping

from ..device import devices_from
from ..shocks import make_shocks
from ..solver.settings import Settings
from ..study import Study


def study_from(values: Mapping, threads: int = 1) -> Study:
    """Rebuild a study from the values that `Config.values` gives."""
    return Study(
        device=devices_from(values["device"]),
        shocks=make_shocks(values["pulse"]),
        model=values["model"],
        settings=Settings(**values["settings"], threads=threads),
        skip=values["skip"],
    )
