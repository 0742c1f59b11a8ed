"""What the rules run, each a function named like its rule; `run_rule` says what they are given.

study: a `Config`, which each job reads anew by `planned_study`
Imports stand in the functions: a job of cells does without xarray.
"""

from dataclasses import replace
from pathlib import Path

from snapmap.config.study import planned_study
from snapmap.files.atomic import replacing
from snapmap.study.axes import NAMES
from snapmap.workflow.job_log import run_rule
from snapmap.workflow.products import products


def simulate_slab(study, axes, path, code):
    """Simulate one slab and write it."""
    from snapmap.sweeps.slabs import write_slab

    counts = write_slab(study, axes, path, code)
    print(f"{path}: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items()))


def collect(study, slab_paths, path):
    """Join slabs on the axes of the whole grid, write the cube and say what is in it."""
    from snapmap.sweeps.collect import collect_slabs
    from snapmap.sweeps.cube import summary

    _write(collect_slabs(slab_paths, study.axes, study.document()), path, summary)


def find_threshold(study, path, table_path, statics_paths):
    """Find the thresholds and write them, also as a table, and the statics of each device."""
    from snapmap.applications.statics.statics import statics
    from snapmap.thresholds.rows import tidy
    from snapmap.thresholds.surface import summary, thresholds_of

    axes = {key: values for key, values in study.axes.items() if key not in (*NAMES, "N")}
    highest, tolerance = float(study.axes["N"][-1]), study.threshold_tolerance
    thresholds = thresholds_of(study.of_thresholds(), axes, tolerance, highest)
    for device, statics_path in zip(study.devices().values(), statics_paths, strict=True):
        _write(statics(device), statics_path)
    with replacing(table_path) as temporary:
        tidy(thresholds).to_csv(temporary, index=False)
    _write(thresholds, path, lambda made: summary(made, study.axes["N"][0], highest))


def trace_cells(study, cube_path, path):
    """Read a cube, follow its cells again and write their motion in brief."""
    from snapmap.applications.page.traces import trace
    from snapmap.study.netcdf import open_whole

    with open_whole(cube_path) as cube:
        traces = trace(study, cube)
        shares = f"{traces.bin_length.size} of {cube.outcome.size} cells"
    _write(traces, path, lambda _: f"{shares} in {traces.sizes['bin']} time bins each")


def simulate_history(study, cell, path):
    """Follow one cell, by its name, beyond its snap, under the first pulse of a study."""
    from snapmap.applications.histories.history import history_of

    history = products(study).histories[cell]
    study = replace(study, device=history.device, shocks=study.shocks.first())
    _write(history_of(study, **history.shock), path)


def check_requirements(study, path):
    """Judge what is required; write a row for each device, corner and C, with what it does."""
    import csv
    from itertools import chain, zip_longest
    from math import nan

    from snapmap.applications.histories.history import Extremes
    from snapmap.applications.requirements import check as requirements
    from snapmap.applications.requirements.verdicts import hint, verdicts_of
    from snapmap.applications.spectra.verdicts import check_spectra, check_vibrations

    C, study, temperatures = study.axes["C"].tolist(), study.of_thresholds(), study.temperatures
    how = temperatures, study.threshold_tolerance
    judged = verdicts_of(study, study.requirements, C, *how)
    verdicts, beside = [one for one, _ in judged], [others for _, others in judged]
    verdicts += check_vibrations(study, study.vibrations, C, temperatures)
    verdicts += check_spectra(study, study.spectra, C, temperatures)
    worst, words = requirements.worst(verdicts)
    words = [requirements.summary(verdicts), words]
    if worst:
        words.append(hint(study, study.requirements, verdicts, worst, *how))
    always = requirements.Verdict, Extremes, requirements.Survival
    columns = dict.fromkeys(chain(*(one._fields for one in always), *beside))
    with replacing(path) as part, open(part, "w", newline="", encoding="utf-8") as file:
        rows = csv.DictWriter(file, columns, restval=nan)
        rows.writeheader()
        for verdict, others in zip_longest(verdicts, beside, fillvalue={}):
            rows.writerow(verdict._asdict() | others)
    print(f"{path}: {'; '.join(filter(None, words))}")


def find_window(study, axes, path):
    """Find where on two axes the required shocks are met, and by which share of devices."""
    from snapmap.applications.window.window import summary, window_of

    found = window_of(study.of_thresholds(), axes, study.requirements, study.tolerances)
    _write(found, path, lambda made: summary(made, study.units))


def find_tolerance(study, path):
    """Find the thresholds of devices whose values scatter."""
    from snapmap.applications.tolerances.dataset import summary, tolerances_of
    from snapmap.study.study import CLOSING

    named = "C", "f0", "N", "temperature"
    axes = {key: study.axes[key] for key in named if key in study.axes}
    made = tolerances_of(study.of_thresholds(), axes, study.tolerances, study.requirements)
    left_out = [required["name"] for required in study.vibrations + study.spectra]
    closing = [one["name"] for one in study.requirements if any(key in one for key in CLOSING)]
    left_out += [f"the closing of {name}" for name in closing]
    if study.requirements and left_out:
        made["yield"].attrs["leaves_out"] = ", ".join(left_out)
    _write(made, path, summary)


def fit_calibration(study, path):
    """Fit the unknowns of a study's calibration to its measured shots."""
    from snapmap.applications.calibration.dataset import calibration_of, summary

    shots, _, unknowns, C = study.calibration
    of_shots = replace(study.of_thresholds(), shocks=study.shocks.first())
    _write(calibration_of(of_shots, shots, unknowns, C), path, summary)


def write_datasheet(study, requirements_path, path, tolerance_path=()):
    """Write verdicts, what is known of devices as made, and the device itself as a data sheet."""
    from contextlib import nullcontext

    from snapmap.applications.datasheet.datasheet import datasheet
    from snapmap.files.tables import read_verdicts
    from snapmap.study.netcdf import open_whole

    verdicts, required = read_verdicts(requirements_path), study.requirements
    with open_whole(tolerance_path) if tolerance_path else nullcontext() as made:
        text = datasheet(study.of_thresholds(), verdicts, required, made, study.title)
    _write_text(text, path)


def _write(dataset, path, summary=None):
    from snapmap.study.netcdf import write

    write(dataset, path)
    if summary:
        print(f"{path}: {summary(dataset)}")


def _write_text(text, path):
    with replacing(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run_rule(globals()[snakemake.rule], snakemake, planned_study)
