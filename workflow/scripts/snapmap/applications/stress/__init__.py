"""The largest stress of each cell, where a beam may break.  Imports: core alone."""

from math import inf
from typing import Any

from ..application import HALF_OF_CORES, Application, Config, Files


class Stress(Application):
    rule, message = "find_stress", "Find the largest stress"
    threads, megabytes, priority = HALF_OF_CORES, 2000, 65

    def outputs(self, study: Config) -> Files:
        """The largest stress of each cell, if a device of the study has a strength."""
        may_break = any(device.strength < inf for device in study.devices().values())
        return {"stress": "results/stress.nc"} if may_break else {}

    def inputs(self, study: Config) -> Files:
        """The cube."""
        return {"cube": "results/cube.nc"}

    def params(self, study: Config) -> dict[str, Any]:
        """All settings of the study, as the cube has them."""
        return {"settings": study.inputs()}

    def run(self, study: Config, cube_path: str, path: str) -> None:
        """Follow the cells of the cube again."""
        from ...study.variables import open_whole, write_product
        from .stress import stress_of_cube

        with open_whole(cube_path) as cube:
            stress = stress_of_cube(study, cube)
            shares = f"{stress.stress_max.size} of {cube.outcome.size} cells"
        write_product(stress, path, lambda _: f"{shares} followed for the largest stress")


application = Stress()
