"""Functions of the core's rules, named like these; applications have functions of their own.

study: a `Config`, which each job reads anew by `planned_study`
Functions import what they need, as a job of cells does without xarray.
"""

import gc
import sys
from functools import partial
from tempfile import TemporaryDirectory

from snapmap.applications import attached, observers
from snapmap.applications.whole import planned_study
from snapmap.study.axes import NAMES
from snapmap.study.provenance import hash_numbers
from snapmap.workflow.job_log import run_rule


def simulate_slab(study, axes, path, code):
    """Simulate a slab, write it, and print the numbers of its outcomes."""
    from snapmap.sweeps.slabs import write_slab

    counts = write_slab(study, axes, path, code, observers())
    print(f"{path}: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items()))


def collect(study, slab_paths, path, code):
    """Join slabs to the cube, write it, and print its summary."""
    from snapmap.study.variables import write_product
    from snapmap.sweeps.cube import collect_slabs, summary

    write_product(collect_slabs(slab_paths, study.axes, study.document(), code), path, summary)


def simulate_all(study, axes, path, code):
    """Simulate the only slab of a small study, and write the cube; the slab is not kept."""
    from snapmap.sweeps.slabs import slab_name, write_slab

    with TemporaryDirectory() as folder:
        slab_path = f"{folder}/{slab_name(study, axes)}.nc"
        write_slab(study, axes, slab_path, code, observers())
        collect(study, [slab_path], path, code)


def find_threshold(study, path, table_path, quick):
    """Find the thresholds and write them, also as a table; run quick applications before.

    quick: files of each quick application by their names, by the names of their folders
    """
    from snapmap.study.variables import write_product
    from snapmap.thresholds.summary import summary, write_thresholds
    from snapmap.thresholds.surface import thresholds_of

    for name, files in quick.items():
        attached()[name].run(study, **{f"{key}_paths": paths for key, paths in files.items()})
    axes = {key: values for key, values in study.axes.items() if key not in (*NAMES, "N")}
    highest, tolerance = float(study.axes["N"][-1]), study.threshold_tolerance
    thresholds = thresholds_of(study.of_thresholds(), axes, tolerance, highest)
    write_thresholds(thresholds, table_path)
    write_product(thresholds, path, lambda made: summary(made, study.axes["N"][0], highest))


def function_of(rule):
    """Give the function of a rule: one of this module, or `run` of an application."""
    of_rules = {part.rule: part.run for part in attached().values()}
    return globals()[rule] if rule in globals() else of_rules[rule]


if __name__ == "__main__":
    gc.set_threshold(200_000)  # of the many objects of imports hardly any is garbage
    if snakemake.rule != "collect":  # no other has lazy arrays, for which xarray imports dask
        sys.modules["dask"] = None
    run_rule(function_of(snakemake.rule), snakemake, partial(hash_numbers, __file__), planned_study)
