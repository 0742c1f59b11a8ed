"""Shocks that must or must not trip a device.  Imports: histories."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from ..application import Application, Config, Figures, Files, Mark

if TYPE_CHECKING:
    from ...pulse.shocks import Shocks
    from .sections import RequiredShock


def shocks_of(study: Config) -> list[RequiredShock]:
    """The required shocks of a study."""
    from .sections import RequiredShock

    required = study.requests.get("requirements", ())
    return [shock for shock in required if isinstance(shock, RequiredShock)]


def plain_shocks(study: Config) -> list[dict[str, Any]]:
    """The required shocks of a study in plain values, on which results depend."""
    return [shock.plain() for shock in shocks_of(study)]


def left_out(study: Config) -> list[str]:
    """Names of what a yield leaves out: vibration, spectra, and closings that shocks demand."""
    shocks = shocks_of(study)
    others = [other.name for other in study.requests.get("requirements", ()) if other not in shocks]
    return others + [f"the {shock.more} of {shock.name}" for shock in shocks if shock.more]


class Requirements(Application):
    rule, message = "check_requirements", "Check the required shocks"
    part, threads, priority = "5 Requirements", 4, 50

    def section(self) -> tuple[Any, str]:
        """A list of requirements of each kind that an application has."""
        from .. import merge
        from .sections import RequirementKind

        kind = RequirementKind(merge(lambda part: part.kinds()))
        return list[Annotated[Any, kind]], "shocks that must, or must not, trip the device"

    def request(self, section: Any, study: Config, document: Any) -> Any:
        """The requirements, by unique names; ValueError, one line, for what a study cannot have."""
        from .sections import read_requirements

        return read_requirements(section or (), study, document.pulse)

    def files(self, study: Config) -> Mapping[str, str]:
        """Recorded shocks among the requirements."""
        named = [shock.shocks.files for shock in shocks_of(study)]
        return {path: sha256 for files in named for path, sha256 in files.items()}

    def doubts(self, study: Config) -> list[str]:
        """Lines about amplitudes that are hardly meant."""
        from ...config.plausible import unusual_runs

        return unusual_runs(N=[shock.N for shock in shocks_of(study)])

    def records(self, study: Config) -> list[tuple[Shocks, float, str]]:
        """Recorded shocks among the requirements."""
        return [(s.shocks, s.f0, s.start) for s in shocks_of(study) if s.shocks.files]

    def marks(self, study: Config) -> list[Mark]:
        """Required shocks, each under all its pulses and directions."""
        marks = []
        for shock in shocks_of(study):
            each = shock.shocks.each()
            pushed = [(single.pulse.section, single.direction, shock.start) for single in each]
            marks.append(Mark(shock.name, shock.f0, shock.N, pushed))
        return marks

    def counts(self, study: Config) -> dict[str, int]:
        """Verdicts, one for each corner of each requirement, under each of its pulses."""
        corners = len(study.devices()) * study.axes["C"].size * max(1, len(study.temperatures))
        pushed = [len(required.shocks.pulses) for required in study.requests["requirements"]]
        return {"verdicts": corners * sum(pushed)}

    def outputs(self, study: Config) -> Files:
        """The table of verdicts."""
        required = study.requests["requirements"]
        return {"requirements": "results/requirements.csv"} if required else {}

    def params(self, study: Config) -> dict[str, Any]:
        """Requirements, C, and the tolerance of thresholds."""
        return {
            "requirements": [requirement.plain() for requirement in study.requests["requirements"]],
            "C": study.axes["C"].tolist(),
            "temperatures": study.temperatures,
            "tolerance": study.threshold_tolerance,
        }

    def inputs(self, study: Config) -> Files:
        """Devices as made, if values scatter."""
        return {"tolerance": "results/tolerance.nc"} if study.requests.get("tolerances") else {}

    def run(self, study: Config, path: str, tolerance_path: str = "") -> None:
        """Judge the requirements, and write a row for each device, corner and C."""
        from ...study.variables import open_whole
        from .summary import sum_up, with_shares
        from .verdict import write_verdicts

        study, requirements = study.of_thresholds(), study.requests["requirements"]
        C = study.axes["C"].tolist()
        verdicts = [verdict for required in requirements for verdict in required.check(study, C)]
        if tolerance_path:
            with open_whole(tolerance_path) as made:
                verdicts = with_shares(verdicts, shocks_of(study), made)
        write_verdicts(verdicts, path, study.unit_of_C)
        print(f"{path}: {sum_up(verdicts)}")

    def figures(self, study: Config) -> Figures:
        """The margins of all requirements."""
        return {"requirements": {"unit_of_C": study.unit_of_C}}

    def draw(self, figures: Figures, folder: str, files: Files) -> None:
        """Draw the margin of each requirement, a row for each worst corner."""
        from ...figures import style
        from .figure import draw_margins
        from .verdict import corners, read_verdicts

        verdicts = read_verdicts(files["requirements"])
        attributes = {"title": "Margins of required shocks"}
        height = 1.2 + 0.32 * len(corners(verdicts))
        saved = style.saved(f"{folder}/requirements", attributes, height)
        with saved as figure:
            draw_margins(figure.subplots(), verdicts, **figures["requirements"])


application = Requirements()
