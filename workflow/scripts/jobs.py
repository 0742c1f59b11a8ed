"""What the rules run, each a function named like its rule; `run_rule` says what they are given.

A study comes as the plain values of `Config.values`, in internal units; axes as in the cube.
Imports stand in the functions: a job of cells does without xarray.
"""

from dataclasses import replace
from pathlib import Path

from snapmap.config.planned import study_from
from snapmap.device import device_from
from snapmap.io.atomic import replacing
from snapmap.io.job_log import run_rule
from snapmap.io.recorded import shocks_of


def simulate_slab(study, axes, path, threads, code):
    """Simulate one slab and write it."""
    from snapmap.sweeps.slabs import write_slab

    counts = write_slab(study_from(study, threads), axes, path, code)
    print(f"{path}: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items()))


def collect(slab_paths, axes, config, path):
    """Join slabs on the axes of the whole grid, write the cube and say what is in it."""
    from snapmap.sweeps.collect import collect_slabs
    from snapmap.sweeps.cube import summary

    _write(collect_slabs(slab_paths, axes, config), path, summary)


def find_threshold(study, axes, tolerance, highest, path, table_path, threads):
    """Find the thresholds and write them, also as a table.

    Rows that stand in the file already, of the same study and code, are not found again.
    """
    from snapmap.io.netcdf import read_earlier
    from snapmap.thresholds.rows import tidy
    from snapmap.thresholds.surface import summary, thresholds_of

    asked = study_from(study, threads), axes, tolerance, highest
    found = thresholds_of(*asked, earlier=read_earlier(path))
    with replacing(table_path) as temporary:
        tidy(found).to_csv(temporary, index=False)
    _write(found, path, summary)


def trace_cells(cube_path, study, path, threads):
    """Read a cube, follow its cells again and write their motion in brief.

    Cells that stand in the file already, of the same study and code, are not followed again.
    """
    from snapmap.io.netcdf import read_earlier
    from snapmap.motion.envelopes import trace

    with _open(cube_path) as cube:
        traces = trace(study_from(study, threads), cube, read_earlier(path))
        shares = f"{traces.bin_length.size} of {cube.outcome.size} cells"
    _write(traces, path, lambda _: f"{shares} in {traces.sizes['bin']} time bins each")


def simulate_history(study, cell, path):
    """Follow one cell, N, f0 and C, beyond its snap, under the first pulse of a study."""
    from snapmap.motion.history import history_of

    study = study_from(study)
    _write(history_of(replace(study, shocks=study.shocks.first()), **cell), path)


def trace_statics(device, path):
    """Push the beam slowly through and write the static force over displacement."""
    from snapmap.beam.statics import statics

    _write(statics(device_from(device)), path)


def check_requirements(study, requirements, vibrations, spectra, C, tolerance, path, threads):
    """Simulate the required shocks; write a row for each device and C, with what it does."""
    import csv
    from itertools import chain, product
    from math import nan

    from snapmap.motion.history import Extremes, extremes_of
    from snapmap.spectra.verdicts import check_spectra, check_vibrations
    from snapmap.thresholds.requirements import Survival, Verdict, check, judge, summary

    study, required = study_from(study, threads), _required(requirements)
    verdicts = check(study, required, C, tolerance)
    asked = product(required, study.devices().values(), C)
    moved, survived = [], []
    for place, (one, device, damping) in enumerate(asked):
        pushed = replace(study, device=device, shocks=one["shocks"])
        moved.append(extremes_of(pushed, one["N"], one["f0"], damping))
        verdicts[place], survival = judge(
            verdicts[place], device, moved[-1].stress_max, one["survives"]
        )
        survived.append(survival)
    shaken = check_vibrations(study, vibrations, C) + check_spectra(study, spectra, C)
    verdicts += shaken
    for rows, kind in ((moved, Extremes), (survived, Survival)):
        rows += [kind(*[nan] * len(kind._fields))] * len(shaken)
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(Verdict._fields + Extremes._fields + Survival._fields)
        rows.writerows(map(chain.from_iterable, zip(verdicts, moved, survived, strict=True)))
    print(f"{path}: {summary(verdicts)}")


def find_tolerance(study, axes, tolerances, requirements, left_out, path, threads):
    """Find the thresholds of devices whose values scatter.

    tolerances: fields of `Tolerances`; left_out: names of requirements that the yield leaves out
    """
    from snapmap.tolerances.dataset import summary, tolerances_of
    from snapmap.tolerances.samples import Tolerances

    asked = axes, Tolerances(**tolerances), _required(requirements)
    found = tolerances_of(study_from(study, threads), *asked)
    if requirements and left_out:
        found["yield"].attrs["leaves_out"] = ", ".join(left_out)
    _write(found, path, summary)


def fit_calibration(study, calibration, path, threads):
    """Fit the unknowns of a config's calibration, its fields by name, to measured shots."""
    from snapmap.calibration.dataset import calibration_of, summary
    from snapmap.io.tables import read_shots

    files = calibration["files"]
    table = read_shots(calibration["shots"], files[calibration["shots"]])
    study = study_from(study, threads)
    study = replace(study, shocks=study.shocks.first())
    found = calibration_of(study, table, calibration["unknowns"], calibration["C"], files)
    _write(found, path, summary)


def write_datasheet(study, C, tolerances, requirements, requirements_path, path, threads):
    """Find what the data sheet tells beside the verdicts, and write it."""
    from snapmap.datasheet import datasheet
    from snapmap.io.tables import read_verdicts
    from snapmap.tolerances.samples import Tolerances

    asked = C, Tolerances(**tolerances) if tolerances else None, _required(requirements)
    verdicts = read_verdicts(requirements_path)
    _write_text(datasheet(study_from(study, threads), *asked, verdicts), path)


def measure_accuracy(device, pulse, axes, settings, plan, path, threads):
    """Measure the error from each source, and the time of a simulation; plan: by name."""
    from snapmap.solver.settings import Settings
    from studies.accuracy.dataset import summary
    from studies.accuracy.measure import measure
    from studies.accuracy.plans import PLANS

    settings = Settings(**settings, threads=threads)
    asked = device_from(device), axes, settings, PLANS[plan], shocks_of(pulse)
    _write(measure(*asked), path, summary)


def write_accuracy_table(accuracy_path, path):
    """Write the tables of docs/accuracy.md."""
    from studies.accuracy.tables import tables

    with _open(accuracy_path) as found:
        _write_text(tables(found), path)


def measure_stability(device, path, threads):
    """Follow the hard cases with every model at many steps and write what each was."""
    from studies.stability.measure import measure

    _write(measure(device_from(device), threads=threads), path)


def measure_settled(device, beam_dampings, path, threads):
    """Sweep a grid with less and more damping of the beam, 1/us."""
    from studies.stability.settled import settled

    _write(settled(device_from(device), beam_dampings, threads), path)


def write_stability_table(stability_path, settled_path, path):
    """Write the tables of docs/stability.md."""
    from studies.stability.tables import tables

    with _open(stability_path) as cases, _open(settled_path) as settled:
        _write_text(tables(cases, settled), path)


def _required(requirements):
    return [one | {"shocks": shocks_of(one["pulse"])} for one in requirements]


def _open(path):
    import xarray as xr

    return xr.open_dataset(path, engine="netcdf4")


def _write(found, path, summary=None):
    from snapmap.io.netcdf import write

    write(found, path)
    if summary:
        print(f"{path}: {summary(found)}")


def _write_text(text, path):
    with replacing(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run_rule(globals()[snakemake.rule], snakemake)
