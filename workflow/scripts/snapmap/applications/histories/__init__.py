"""The motion of single cells in full.  Imports: core alone."""

from typing import Any

from ..application import Application, Config, Figures, Files


class Histories(Application):
    rule, message = "simulate_histories", "Follow single cells in full"
    part, size = "8 Histories", (4.2, 2)

    def section(self) -> tuple[Any, str]:
        """A list of cells, each with N, and f0, duration and C unless the study gives them."""
        from .sections import CellSection

        return list[CellSection], "cells {N, f0 or duration, C} whose motion is kept"

    def request(self, section: Any, study: Config, document: Any) -> Any:
        """The cells, each with its device."""
        from .sections import read_cells

        return read_cells(section or (), study)

    def alone(self, study: Config) -> list[float]:
        """f0 of the cells, Hz."""
        return [cell.f0 for cell in study.requests["histories"]]

    def counts(self, study: Config) -> dict[str, int]:
        """The cells."""
        return {"histories": len(study.requests["histories"])}

    def doubts(self, study: Config) -> list[str]:
        """Lines about amplitudes that are hardly meant."""
        from ...config.plausible import unusual_runs

        return unusual_runs(N=[cell.N for cell in study.requests["histories"]])

    def outputs(self, study: Config) -> Files:
        """A file for each cell."""
        cells = study.requests["histories"]
        return {"history": [f"results/histories/{cell.name}.nc" for cell in cells]} if cells else {}

    def params(self, study: Config) -> dict[str, Any]:
        """Each cell with its device."""
        from ...study.provenance import device_sections

        cells = study.requests["histories"]
        return {"cells": [cell.shock | device_sections(cell.device) for cell in cells]}

    def run(self, study: Config, history_paths: list[str]) -> None:
        """Follow each cell beyond its snap, under the first pulse of the study."""
        from dataclasses import replace

        from ...study.axes import attributes_of
        from ...study.variables import write
        from .history import history_of

        shocks = study.shocks.first()
        for cell, path in zip(study.requests["histories"], history_paths, strict=True):
            history = history_of(replace(study, device=cell.device).under(shocks), **cell.shock)
            at = {key: ((), value, attributes_of(key)) for key, value in cell.changes.items()}
            write(history.assign_coords(at), path)

    def figures(self, study: Config) -> Figures:
        """A figure for each cell."""
        return {f"history_{cell.name}": {} for cell in study.requests["histories"]}


application = Histories()
