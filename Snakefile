import os
import sys
from dataclasses import asdict
from pathlib import Path

import platformdirs
from snakemake.exceptions import WorkflowError

# Jobs inherit both: nothing is written beside the code, and a kernel is compiled once per user.
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
os.environ.setdefault(
    "NUMBA_CACHE_DIR", str(platformdirs.user_cache_path("snapmap") / "numba")
)
sys.dont_write_bytecode = True

# Snakemake puts the folder of the Snakefile on the path.
from workflow.scripts.snapmap.config import load_study
from workflow.scripts.snapmap.slab import cut, slab_name

if not workflow.overwrite_configfiles:

    configfile: Path(workflow.basedir) / "config" / "config.yaml"


try:
    study = load_study(config)
    rows = cut(study)
except ValueError as error:
    raise WorkflowError(str(error))

names = [[slab_name(study, slab) for slab in row] for row in rows]
slabs = {slab_name(study, slab): slab for row in rows for slab in row}
dampings = [f"{C:.15g}" for C in study.C]
cells = {"N{:.15g}_f{:.15g}_C{:.15g}".format(*cell): cell for cell in study.histories}


def code(*modules):
    """The package's modules a rule depends on: Snakemake does not follow imports."""
    package = Path(workflow.basedir) / "workflow" / "scripts" / "snapmap"
    return [str(path) for module in modules for path in sorted(package.glob(module))]


SOLVER = code(
    *[
        "device.py",
        "bases/*.py",
        "modal.py",
        "wells.py",
        "models.py",
        "lanes.py",
        "reference.py",
    ]
)


wildcard_constraints:
    slab="[0-9a-f]+",
    damping="[^/]+",
    cell="[^/]+",
    size="|_quick",


rule all:
    input:
        "results/cube.nc",
        expand(
            "results/figures/map_C{damping}.{kind}",
            damping=dampings,
            kind=["pdf", "png"],
        ),
        expand("results/figures/history_{cell}.{kind}", cell=cells, kind=["pdf", "png"]),
        expand("results/figures/accuracy_quick.{kind}", kind=["pdf", "png"]),


rule simulate_slab:
    input:
        code=[
            *SOLVER,
            *code(
                *["cells.py", "protocol.py", "thresholds.py", "ladder.py"],
                *["outcome.py", "grid.py", "slab.py"],
            ),
        ],
    output:
        slab="results/slabs/{slab}.nc",
    threads: 1
    params:
        device=asdict(study.device),
        model=study.model,
        axes=lambda wildcards: slabs[wildcards.slab]._asdict(),
        protocol=study.protocol._asdict(),
    message:
        "Simulate slab {wildcards.slab}"
    script:
        "workflow/scripts/simulate_slab.py"


rule collect:
    input:
        slabs=[f"results/slabs/{name}.nc" for row in names for name in row],
        code=code("cube.py", "provenance.py"),
    output:
        cube="results/cube.nc",
    params:
        names=names,
        config=config,
    message:
        "Collect {input.slabs} into one cube"
    script:
        "workflow/scripts/collect.py"


rule draw_map:
    input:
        cube="results/cube.nc",
        code=code(
            "figures/maps.py",
            "figures/style.py",
            "figures/paper.mplstyle",
            "quantity.py",
        ),
    output:
        pdf="results/figures/map_C{damping}.pdf",
        png="results/figures/map_C{damping}.png",
    params:
        damping_index=lambda wildcards: dampings.index(wildcards.damping),
    message:
        "Draw the map for C = {wildcards.damping} uN us/um"
    script:
        "workflow/scripts/draw_map.py"


rule simulate_history:
    input:
        code=[*SOLVER, *code("cells.py", "history.py", "provenance.py")],
    output:
        history="results/histories/{cell}.nc",
    params:
        device=asdict(study.device),
        model=study.model,
        cell=lambda wildcards: cells[wildcards.cell]._asdict(),
        horizon=study.protocol.horizon,
    message:
        "Follow one cell in full: {wildcards.cell}"
    script:
        "workflow/scripts/simulate_history.py"


rule draw_history:
    input:
        history="results/histories/{cell}.nc",
        code=code(
            "figures/histories.py",
            "figures/style.py",
            "figures/paper.mplstyle",
            "quantity.py",
        ),
    output:
        pdf="results/figures/history_{cell}.pdf",
        png="results/figures/history_{cell}.png",
    message:
        "Draw the history of {wildcards.cell}"
    script:
        "workflow/scripts/draw_history.py"


rule accuracy:
    input:
        "results/accuracy.nc",
        expand("results/figures/accuracy.{kind}", kind=["pdf", "png"]),


rule measure_accuracy:
    input:
        code=[
            *SOLVER,
            *code(
                "cells.py",
                "protocol.py",
                "thresholds.py",
                "ladder.py",
                "outcome.py",
                "grid.py",
            ),
            *code("accuracy.py", "provenance.py"),
        ],
    output:
        accuracy="results/accuracy{size}.nc",
    # All there are: another job at the same time would spoil the times.
    threads: 1000
    params:
        device=asdict(study.device),
        axes=[study.C.tolist(), study.f0.tolist(), study.N.tolist()],
        protocol=study.protocol._asdict(),
        plan=lambda wildcards: "quick" if wildcards.size else "full",
    message:
        "Measure error and time of every model: {output.accuracy}"
    script:
        "workflow/scripts/measure_accuracy.py"


rule draw_accuracy:
    input:
        accuracy="results/accuracy{size}.nc",
        code=code("figures/accuracy.py", "figures/style.py", "figures/paper.mplstyle"),
    output:
        pdf="results/figures/accuracy{size}.pdf",
        png="results/figures/accuracy{size}.png",
    message:
        "Draw error against time: {output.pdf}"
    script:
        "workflow/scripts/draw_accuracy.py"


rule stability:
    input:
        "results/stability.md",
        expand("results/figures/stability.{kind}", kind=["pdf", "png"]),
        expand("results/figures/settled.{kind}", kind=["pdf", "png"]),


rule measure_stability:
    input:
        code=[
            *SOLVER,
            *code("cells.py", "protocol.py", "thresholds.py", "outcome.py"),
            *code("stability.py", "cube.py", "provenance.py"),
        ],
    output:
        stability="results/stability.nc",
    # All there are: no other rule takes as long.
    threads: 1000
    params:
        device=asdict(study.device),
    message:
        "Follow the hard cases"
    script:
        "workflow/scripts/measure_stability.py"


rule measure_settled:
    input:
        code=[
            *SOLVER,
            *code(
                "cells.py",
                "protocol.py",
                "thresholds.py",
                "ladder.py",
                "outcome.py",
                "grid.py",
            ),
            *code("cube.py", "provenance.py"),
        ],
    output:
        settled="results/settled.nc",
    threads: 1000
    params:
        device=asdict(study.device),
        beam_dampings=[0.0, 4e-4, 4e-3],
    message:
        "Sweep with less and more damping"
    script:
        "workflow/scripts/measure_settled.py"


rule draw_stability:
    input:
        stability="results/stability.nc",
        code=code("figures/stability.py", "figures/style.py", "figures/paper.mplstyle"),
    output:
        pdf="results/figures/stability.pdf",
        png="results/figures/stability.png",
    message:
        "Draw the hard cases"
    script:
        "workflow/scripts/draw_stability.py"


rule draw_settled:
    input:
        settled="results/settled.nc",
        code=code(
            "figures/maps.py",
            "figures/style.py",
            "figures/paper.mplstyle",
            "quantity.py",
        ),
    output:
        pdf="results/figures/settled.pdf",
        png="results/figures/settled.png",
    params:
        beam_dampings=[0.0, 4e-4],
        C=25.0,
    message:
        "Draw what is settled without and with damping of the beam"
    script:
        "workflow/scripts/draw_settled.py"


rule write_stability_table:
    input:
        stability="results/stability.nc",
        settled="results/settled.nc",
        code=code("stability.py", "outcome.py"),
    output:
        table="results/stability.md",
    message:
        "Write the tables of docs/stability.md"
    script:
        "workflow/scripts/write_stability_table.py"
