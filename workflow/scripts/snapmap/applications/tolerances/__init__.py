"""Devices as made: values that scatter.  Imports: requirements."""

from typing import Any

from ..application import Application, Config, Figures, Files
from ..requirements import left_out, plain_shocks, shocks_of

AXES = "C", "f0", "N", "temperature"


class Tolerances(Application):
    rule, message = "find_tolerance", "Find the thresholds of devices as made"
    part, threads, megabytes, priority = "6 Devices as made", 4, 4000, 45

    def section(self) -> tuple[Any, str]:
        """The values that scatter, and the number of samples."""
        from .sections import TolerancesSection

        return TolerancesSection, "what scatters between devices, or between shocks"

    def request(self, section: Any, study: Config, document: Any) -> Any:
        """The `Tolerances`, or None; ValueError, one line, if a device cannot have them."""
        from ...device.samples import Plan

        if not section:
            return None
        tolerances = section.tolerances()
        for device in study.devices().values():
            Plan(device, tolerances.scatters, tolerances.together)
        study.set_out({})
        return tolerances

    def doubts(self, study: Config) -> list[str]:
        """Lines about scatters that are hardly meant, and devices as made that are no switch."""
        from ...config.plausible import no_switches, wide
        from ...device.samples import Plan

        made, lines = study.requests["tolerances"], []
        for name, device in study.devices().items() if made else ():
            plan = Plan(device, made.scatters, made.together)
            lost = no_switches(device, plan, made.samples, made.seed)
            lines += wide(plan) + [f"{name}: {line}" for line in lost]
        return lines

    def counts(self, study: Config) -> dict[str, int]:
        """Thresholds of the samples, those that estimate Sobol indices among them."""
        made, C, f0 = study.requests["tolerances"], study.axes["C"].size, study.axes["f0"].size
        if not made:
            return {}
        of_indices = f0 * len(study.shocks.pulses) * made.power * (1 + len(made.scatters))
        required = len(shocks_of(study)) * max(1, len(study.temperatures))
        rows = of_indices + (f0 * len(study.shocks.pulses) + required) * made.samples
        return {"thresholds of devices as made": len(study.devices()) * C * rows}

    def outputs(self, study: Config) -> Files:
        """Thresholds, probabilities and the yield."""
        return {"tolerance": "results/tolerance.nc"} if study.requests["tolerances"] else {}

    def params(self, study: Config) -> dict[str, Any]:
        """Axes, tolerances, required shocks, and what the yield leaves out."""
        return {
            "axes": [study.axes[key].tolist() for key in AXES if key in study.axes],
            "tolerances": study.requests["tolerances"].section,
            "index_samples": study.requests["tolerances"].index_samples,
            "requirements": plain_shocks(study),
            "left_out": left_out(study),
        }

    def run(self, study: Config, path: str) -> None:
        """Find the thresholds of devices whose values scatter."""
        from ...study.variables import write_product
        from .dataset import summary, tolerances_of

        axes = {key: study.axes[key] for key in AXES if key in study.axes}
        plan, requirements = study.requests["tolerances"], shocks_of(study)
        dataset = tolerances_of(study.of_thresholds(), axes, plan, requirements)
        if requirements and left_out(study):
            dataset["yield"].attrs["leaves_out"] = ", ".join(left_out(study))
        write_product(dataset, path, summary)

    def figures(self, study: Config) -> Figures:
        """Probability and sensitivity by shape and direction, and the yield of each device."""
        from ...config.views import batch_places
        from ...study.axes import DEVICE

        places = batch_places(study.grid, "probability") | batch_places(study.grid, "sensitivity")
        if shocks_of(study):
            places |= batch_places(study.grid, "yield", of=[DEVICE])
        return {name: {"at": at} for name, at in places.items()}

    def draw(self, figures: Figures, folder: str, files: Files) -> None:
        """Draw the probability of a snap, the sensitivity of thresholds, and the yield."""
        from ...study.variables import open_whole
        from .figure import draw_stem

        with open_whole(files["tolerance"]) as dataset:
            for stem, where in figures.items():
                draw_stem(f"{folder}/{stem}", dataset.isel(where["at"]))


application = Tolerances()
