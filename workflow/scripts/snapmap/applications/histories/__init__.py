"""The motion of single cells in full.  Imports: core alone."""

public = {"simulate": "history"}
rule, message = "simulate_histories", "Follow single cells in full"
part = "8 Histories"


def section():
    """A list of cells, each with N, f0 or duration, and C."""
    from ...config.keys import many
    from .sections import CellSection

    return many(CellSection, "a list of cells {N, f0 or duration, C}", out="none")


def described():
    """Its sections, as docs/config.md has them."""
    from .sections import CellSection

    return {"each of histories": CellSection}


def request(sections, study, document):
    """The cells, each with its device."""
    from .sections import read_cells

    return read_cells(sections or (), study.device)


def alone(study):
    """f0 of the cells, Hz."""
    return [cell.f0 for cell in study.requests["histories"]]


def doubts(study):
    """Lines about amplitudes that are hardly meant."""
    from ...config.plausible import unusual_runs

    return unusual_runs(N=[cell.N for cell in study.requests["histories"]])


def outputs(study):
    """A file for each cell."""
    cells = study.requests["histories"]
    return {"history": [f"results/histories/{cell.name}.nc" for cell in cells]} if cells else {}


def params(study):
    """Each cell with its device."""
    from ...study.provenance import device_sections

    cells = study.requests["histories"]
    return {"cells": [cell.shock | device_sections(cell.device) for cell in cells]}


def run(study, history_paths):
    """Follow each cell beyond its snap, under the first pulse of the study."""
    from dataclasses import replace

    from ...study.netcdf import write
    from .history import history_of

    shocks = study.shocks.first()
    for cell, path in zip(study.requests["histories"], history_paths, strict=True):
        write(history_of(replace(study, device=cell.device, shocks=shocks), **cell.shock), path)


def figures(study):
    """A figure for each cell."""
    return {f"history_{cell.name}": {} for cell in study.requests["histories"]}


def draw(figures, folder, history_paths):
    """Draw motion, forces and energies over time, a figure for each cell."""
    from ...figures import style
    from ...study.netcdf import open_whole
    from .figure import draw_history

    for stem, path in zip(figures, history_paths, strict=True):
        with (
            open_whole(path) as dataset,
            style.saved(f"{folder}/{stem}", dataset.attrs, 4.2) as figure,
        ):
            axes = figure.subplots(3, sharex=True, height_ratios=[2, 1, 1])
            draw_history(axes, dataset)
