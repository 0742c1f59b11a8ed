"""The map in three laws: dwell, snap time, velocity change.  Imports: core alone."""

from typing import Any

from ..application import Application, Config, Figures, Files


class Laws(Application):
    rule, message = "find_laws", "Find where the three laws hold"
    part, size = "2 Thresholds", (4.6, 2)

    def section(self) -> tuple[Any, str]:
        """Whether the laws are compared with the thresholds."""
        from ...values.quantities import Truth

        return Truth, "whether [three laws](applications/laws.md) are fitted to the thresholds"

    def request(self, section: Any, study: Config, document: Any) -> Any:
        """Whether the laws are compared with the thresholds; ValueError beside a user's own."""
        if section and study.model.laws:  # the three laws are of the device's own forces
            raise ValueError("does not work with model.laws; leave one of them out")
        return bool(section)

    def outputs(self, study: Config) -> Files:
        """The laws beside the thresholds."""
        return {"laws": "results/laws.nc"} if study.requests["laws"] else {}

    def inputs(self, study: Config) -> Files:
        """The thresholds."""
        return {"threshold": "results/threshold.nc"}

    def run(self, study: Config, threshold_path: str, path: str) -> None:
        """Compare the laws with the thresholds of the first device and pulse."""
        from ...study.variables import open_whole, write_product
        from .laws import laws_of, summary

        with open_whole(threshold_path) as thresholds:
            write_product(laws_of(study.of_thresholds(), study.grid, thresholds), path, summary)

    def figures(self, study: Config) -> Figures:
        """A figure over f0."""
        return {"laws": {}}


application = Laws()
