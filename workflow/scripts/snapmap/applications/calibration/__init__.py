"""Values of a device estimated from measured shots.  Imports: core alone."""

from collections.abc import Mapping
from typing import Any

from ...pulse.shocks import Shocks
from ..application import Application, Config, Figures, Files


class Calibration(Application):
    rule, message = "fit_calibration", "Estimate values of the device from measured shots"
    part, size, threads, priority = "6 Devices as made", (3.4, 2), 4, 45

    def section(self) -> tuple[Any, str]:
        """Shots and unknowns of a config."""
        from .shots import CalibrationSection

        return CalibrationSection, "values estimated from measured shots"

    def request(self, section: Any, study: Config, document: Any) -> Any:
        """The `Calibration`, or None; ValueError, one line, for an invalid section."""
        from .shots import read_calibration

        if not section:
            return None
        return read_calibration(section, study.device, study.shocks, study.axes["C"])

    def files(self, study: Config) -> Mapping[str, str]:
        """The table of shots, and the recorded shocks that it names."""
        return study.requests["calibration"].files if study.requests["calibration"] else {}

    def records(self, study: Config) -> list[tuple[Shocks, float, str]]:
        """Recorded shocks among the shots."""
        asked = study.requests["calibration"]
        groups = asked.shots.groups if asked else ()
        recorded = [group for group in groups if "file" in group.pulse.section]
        return [(Shocks(group.pulse), group.f0, study.start) for group in recorded]

    def refuse(self, study: Config) -> None:
        """Raise ValueError, one line, for shots that no device of the ranges can give."""
        if asked := study.requests["calibration"]:
            from .dataset import refuse_far

            refuse_far(study.of_thresholds(), asked.shots, asked.unknowns, asked.C)

    def outputs(self, study: Config) -> Files:
        """The estimates."""
        return {"calibration": "results/calibration.nc"} if study.requests["calibration"] else {}

    def params(self, study: Config) -> dict[str, Any]:
        """Files with their SHA-256, unknowns and C."""
        return {"calibration": list(study.requests["calibration"][1:])}

    def run(self, study: Config, path: str) -> None:
        """Fit the unknowns to the shots."""
        from ...study.variables import write_product
        from .dataset import calibration_of, summary

        shots, _, unknowns, C = study.requests["calibration"]
        of_shots = study.of_thresholds().under(study.shocks.first())
        write_product(calibration_of(of_shots, shots, unknowns, C), path, summary)

    def figures(self, study: Config) -> Figures:
        """A figure of all shots."""
        return {"calibration": {}}


application = Calibration()
