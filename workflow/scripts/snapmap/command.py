"""The command `snapmap`: a config to begin with, what it would cost, and its run."""

import shutil
import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from math import prod
from pathlib import Path

from .io.extras import needing
from .io.named import naming

PACKAGE = Path(__file__).parent
PIPELINE = next(path for path in (PACKAGE / "pipeline", PACKAGE.parents[2]) if path.is_dir())
"""The folder of the Snakefile: in a wheel within the package, else that of the checkout."""
CONFIG = "config.yaml"
START, PER_FIGURE, PER_TRACE = 2.5, 0.9, 4e-3
"""Core time of a job's start and loading, of a figure, and of a cell's motion, s; seen."""


def main(words: Sequence[str] | None = None) -> int:
    """Run the command with its arguments, the process's by default; returns its exit status."""
    parser = ArgumentParser("snapmap", description="Snap maps of a bistable beam under shock.")
    verbs = parser.add_subparsers(required=True, metavar="init, check or run")
    verb = verbs.add_parser("init", help="write a config with comments, to begin with")
    verb.add_argument("folder", nargs="?", default=".", type=Path)
    verb.set_defaults(do=init)
    for do, what in (check, "name faults, cost and doubts of a config"), (run, "make its results"):
        verb = verbs.add_parser(do.__name__, help=what)
        verb.add_argument("config", type=Path)
        verb.set_defaults(do=do)
    verb.add_argument("--cores", default="all", help="by default all")
    known, others = parser.parse_known_args(words)
    given = vars(known)
    if known.do is run:
        given["others"] = others  # Snakemake's: -n, targets
    elif others:
        parser.error(f"unrecognized arguments: {' '.join(others)}")
    try:
        given.pop("do")(**given)
    except (ImportError, OSError, ValueError) as fault:
        print(fault, file=sys.stderr)
        return 1
    return 0


def init(folder: Path) -> None:
    """Write the config of a sensor, with comments, into a folder; ValueError if one is there."""
    path = folder / CONFIG
    with naming(path):
        if path.exists() or path.is_symlink():
            raise ValueError("is there already; name another folder")
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(PIPELINE / "config" / "sensor.yaml", path)
    print(f"{path}: write your device there, then: snapmap check {path}")


def check(config: Path) -> None:
    """Print what a config describes, its doubts and its cost; raises ValueError, a line a fault."""
    with needing("snapmap check"):
        from .config.doubts import descriptions, doubts
        from .config.study import load_config
        from .config.yaml_file import read_document
    from .solver.cost import spoken
    from .sweeps.plan import SEEN, make_plan

    study = load_config(read_document(config))
    plan = make_plan(study.grid, study.model, study.settings, [h.f0 for h in study.histories])
    for line in filter(None, [*descriptions(study), study.left_out, *doubts(study)]):
        print(line)
    sizes = ", ".join(f"{key} {values.size}" for key, values in study.axes.items())
    costs = {"cells": " to ".join(spoken(times * plan.seconds) for times in SEEN)}
    costs |= {what: spoken(START + seconds) for what, seconds in _costs(study).items()}
    print(f"{prod(study.grid.shape)} cells ({sizes}) in {len(plan.slabs)} jobs of one core")
    print(f"core time, about: {', '.join(f'{what} {time}' for what, time in costs.items())}")


def _costs(study):
    """Core time of each job beside those of the cells, but for its start, s, about."""
    import numpy as np

    from .config.products import products
    from .device import batch
    from .motion.envelopes import CELLS
    from .solver.adaptive import choose_survey
    from .solver.cells import rows_of, to_rows
    from .study import of_requirement
    from .thresholds.cost import PER_ROW, PER_SAMPLE, run_seconds, survey_seconds

    C, f0, scatter = study.axes["C"], study.axes["f0"], study.tolerances
    models = choose_survey(study.grid.device, study.model, study.settings.start)
    rows = rows_of(study.grid)
    costs = {"thresholds": survey_seconds(models, rows.take(rows.device >= 0), study.settings)}
    if study.traces or study.has_strength:
        costs["traces"] = PER_TRACE * min(CELLS, prod(study.grid.shape))
    costs |= dict.fromkeys(["requirements"] * bool(study.requirements), 0.0)
    costs |= dict.fromkeys(["tolerances"] * bool(scatter), 0.0)
    for device in study.devices().values():
        models = choose_survey(batch([device]), study.model)
        corners = len(study.temperatures) or 1

        def samples(rows, count, models=models):
            seconds = run_seconds(models.decides, rows, study.settings).sum()
            return (PER_ROW + PER_SAMPLE * count) * float(seconds)

        for required in study.requirements:
            pulses = required["shocks"].pulses
            pulse = np.arange(len(pulses))[:, np.newaxis]
            rows = to_rows(0, required["f0"], C, pulse, pulses)
            settings = of_requirement(study, required).settings
            costs["requirements"] += corners * survey_seconds(models, rows, settings)
            if scatter:
                costs["tolerances"] += corners * samples(rows, scatter.samples)
        if scatter:
            pulse = np.arange(len(study.grid.pulses))[:, np.newaxis, np.newaxis]
            rows = to_rows(0, f0, C[:, np.newaxis], pulse, study.grid.pulses)
            every = scatter.samples + scatter.power * (1 + len(scatter.scatters))
            costs["tolerances"] += samples(rows, every)
    costs |= _shaken(study)
    if study.calibration:
        costs["calibration"] = _calibrated(study)
    if study.histories:
        costs["histories"] = START * (len(study.histories) - 1)
    costs |= dict.fromkeys(["data sheet"] * bool(study.all_required), 0.0)
    return costs | {"figures": PER_FIGURE * len(products(study).stems)}


def _shaken(study):
    """Core time in which records of every vibration and spectrum are followed, s, about."""
    from .device import batch
    from .shocks import make_shocks
    from .solver.adaptive import choose_survey
    from .solver.cells import to_rows
    from .spectra import srs, trips, vibration
    from .spectra.psd import Spectrum
    from .thresholds.cost import record_seconds

    costs = dict.fromkeys(["vibration"] * bool(study.vibrations), 0.0)
    costs |= dict.fromkeys(["spectra"] * bool(study.spectra), 0.0)
    for device in study.devices().values():
        model = choose_survey(batch([device]), study.model).decides

        def records(pulse, length, model, horizon, count):
            rows = to_rows(0, 1 / length, study.axes["C"], 0, (pulse,))
            settings = study.settings._replace(horizon=horizon)
            return record_seconds(model, rows, settings, count) * (len(study.temperatures) or 1)

        for required in study.vibrations:
            length = Spectrum(required["psd"]).record_length(required["duration"])
            pulse, _ = Spectrum(required["psd"]).record(length, [vibration.SEED, 0])
            finer = model.with_step(vibration.STEP)
            costs["vibration"] += records(pulse, length, finer, 0.0, vibration.RECORDS)
        for required in study.spectra:
            pulse = srs.record(srs.check_points(required["srs"]), [trips.SEED, 0]).pulse
            count = trips.RECORDS * len(make_shocks(direction=required["direction"]).pulses)
            length, horizon = 1e-6 * pulse.duration, study.settings.horizon
            costs["spectra"] += count * srs.draw_seconds(required["srs"], pulse) + records(
                pulse, length, model, horizon, count
            )
    return costs


def _calibrated(study):
    """Core time in which thresholds over the ranges of a calibration are found, s, about."""
    from .calibration.surface import CHECKED, POINTS
    from .device import batch
    from .solver.adaptive import choose_survey
    from .solver.cells import to_rows
    from .thresholds.cost import PER_SAMPLE, run_seconds

    shots, _, unknowns, C = study.calibration
    groups, size = shots.groups, len(unknowns)
    pulses = tuple(group.pulse for group in groups)
    C = sum(unknowns["C"]) / 2 if C is None else C
    rows = to_rows(0, [group.f0 for group in groups], C, range(len(pulses)), pulses)
    model = choose_survey(batch([study.device]), study.model).decides
    points = CHECKED + POINTS[size] ** size
    return PER_SAMPLE * points * float(run_seconds(model, rows, study.settings).sum())


def run(config: Path, cores: str, others: Sequence[str] = ()) -> None:
    """Run the workflow in the current folder, and exit as Snakemake does; ValueError, one line.

    others: options and targets of Snakemake's, such as -n
    """
    with needing("snapmap run"):
        from snakemake.cli import main as snakemake

        from .config.yaml_file import read_document
    read_document(config)  # Snakemake would evaluate what is behind __use_yte__, not refuse it
    asked = [
        "--snakefile",
        PIPELINE / "Snakefile",
        "--configfile",
        config,
        "--cores",
        cores,
        *others,
    ]
    snakemake([str(word) for word in asked])


if __name__ == "__main__":
    sys.exit(main())
