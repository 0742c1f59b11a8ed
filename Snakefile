import fcntl
import os
import sys
from dataclasses import asdict
from pathlib import Path

import platformdirs
from snakemake.exceptions import WorkflowError

# Jobs inherit both: nothing is written beside the code, and a kernel is compiled once per user.
os.environ.update(PYTHONDONTWRITEBYTECODE="1")
os.environ.setdefault(
    "NUMBA_CACHE_DIR", str(platformdirs.user_cache_path("snapmap") / "numba")
)
sys.dont_write_bytecode = True

# Snakemake puts the folder of the Snakefile on the path.
from workflow.scripts.snapmap.atomic import remove_leftovers
from workflow.scripts.snapmap.config import load_study
from workflow.scripts.snapmap.document import read_document
from workflow.scripts.snapmap.plan import cut, requests
from workflow.scripts.snapmap.slab import slab_name

if not workflow.overwrite_configfiles:

    configfile: Path(workflow.basedir) / "config" / "config.yaml"


try:
    for path in workflow.overwrite_configfiles:
        read_document(path)  # Snakemake keeps the last of two equal keys without a word
    study = load_study(config)
    slabs = {slab_name(study, slab): slab for slab in cut(study)}
    asked = requests(study, slabs)
except ValueError as error:
    raise WorkflowError(str(error))

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
PLOT = code("figures/style.py", "figures/paper.mplstyle", "quantity.py", "atomic.py")


report: "workflow/report/study.rst"


wildcard_constraints:
    slab="[0-9a-f_]+",
    damping="[^/]+",
    cell="[^/]+",
    size="|_quick",


onstart:
    # Snakemake's own lock outlives a killed run, and its profile leaves it out; the system's is
    # gone with the process that held it.
    running = os.open(".snakemake/running", os.O_CREAT | os.O_WRONLY)
    try:
        fcntl.flock(running, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise WorkflowError(f"{os.getcwd()}: another run is at work in this folder")
    remove_leftovers("results")


rule all:
    input:
        "results/cube.nc",
        expand(
            "results/figures/map_C{damping}.{kind}",
            damping=dampings,
            kind=["pdf", "png"],
        ),
        expand("results/figures/history_{cell}.{kind}", cell=cells, kind=["pdf", "png"]),
        expand(
            "results/figures/{stem}.{kind}",
            stem=[
                "maps",
                "thresholds",
                "damage_boundary",
                "statics",
                "accuracy_quick",
            ],
            kind=["pdf", "png"],
        ),
        "results/explore.html",


rule simulate_slab:
    input:
        code=[
            *SOLVER,
            *code(
                *["cells.py", "protocol.py", "thresholds.py", "ladder.py"],
                *["outcome.py", "grid.py", "slab.py", "recall.py", "atomic.py"],
            ),
        ],
    output:
        slab="results/slabs/{slab}.nc",
    log:
        "results/logs/simulate_slab_{slab}.log",
    retries: 1
    conda:
        "workflow/envs/snapmap.yaml"
    threads: 1
    resources:
        mem_mb=lambda wildcards, attempt: attempt * asked[wildcards.slab].mem_mb,
        runtime=lambda wildcards, attempt: attempt * asked[wildcards.slab].runtime,
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
        slabs=[f"results/slabs/{name}.nc" for name in slabs],
        code=code("collection.py", "cube.py", "provenance.py", "atomic.py"),
    output:
        cube="results/cube.nc",
    log:
        "results/logs/collect.log",
    conda:
        "workflow/envs/snapmap.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
    params:
        axes=[study.C.tolist(), study.f0.tolist(), study.N.tolist()],
        config=config,
    message:
        "Collect the slabs into {output.cube}"
    script:
        "workflow/scripts/collect.py"


rule find_threshold:
    input:
        code=[
            *SOLVER,
            *code(
                "cells.py", "protocol.py", "thresholds.py", "ladder.py", "statics.py"
            ),
            *code("edges.py", "survey.py", "surface.py", "provenance.py", "atomic.py"),
        ],
    output:
        threshold="results/threshold.nc",
    log:
        "results/logs/find_threshold.log",
    conda:
        "workflow/envs/snapmap.yaml"
    threads: 4
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
    params:
        device=asdict(study.device),
        model=study.model,
        axes={"C": study.C.tolist(), "f0": study.f0.tolist()},
        highest=float(study.N[-1]),
        horizon=study.protocol.horizon,
        tolerance=study.threshold_tolerance,
    message:
        "Find the thresholds"
    script:
        "workflow/scripts/find_threshold.py"


rule trace_statics:
    input:
        code=[
            *code("device.py", "bases/*.py", "modal.py", "wells.py", "statics.py"),
            *code("provenance.py", "atomic.py"),
        ],
    output:
        statics="results/statics.nc",
    log:
        "results/logs/trace_statics.log",
    conda:
        "workflow/envs/snapmap.yaml"
    params:
        device=asdict(study.device),
    message:
        "Push the beam slowly through"
    script:
        "workflow/scripts/trace_statics.py"


rule draw_map:
    input:
        cube="results/cube.nc",
        threshold="results/threshold.nc",
        code=[*code("figures/maps.py", "figures/curves.py"), *PLOT],
    output:
        pdf="results/figures/map_C{damping}.pdf",
        png=report(
            "results/figures/map_C{damping}.png",
            caption="workflow/report/map.rst",
            category="Maps",
            labels={"figure": "C = {damping} uN us/um"},
        ),
    log:
        "results/logs/draw_map_{damping}.log",
    conda:
        "workflow/envs/snapmap.yaml"
    params:
        damping_index=lambda wildcards: dampings.index(wildcards.damping),
    message:
        "Draw the map for C = {wildcards.damping} uN us/um"
    script:
        "workflow/scripts/draw_map.py"


rule draw_maps:
    input:
        cube="results/cube.nc",
        threshold="results/threshold.nc",
        code=[*code("figures/maps.py", "figures/curves.py"), *PLOT],
    output:
        pdf="results/figures/maps.pdf",
        png=report(
            "results/figures/maps.png",
            caption="workflow/report/maps.rst",
            category="Maps",
            labels={"figure": "all C"},
        ),
    log:
        "results/logs/draw_maps.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw the maps of all C side by side"
    script:
        "workflow/scripts/draw_maps.py"


rule draw_thresholds:
    input:
        threshold="results/threshold.nc",
        code=[*code("figures/thresholds.py", "figures/curves.py"), *PLOT],
    output:
        pdf="results/figures/thresholds.pdf",
        png=report(
            "results/figures/thresholds.png",
            caption="workflow/report/thresholds.rst",
            category="Thresholds",
            labels={"figure": "over the pulse's frequency"},
        ),
    log:
        "results/logs/draw_thresholds.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw the thresholds"
    script:
        "workflow/scripts/draw_thresholds.py"


rule draw_damage_boundary:
    input:
        threshold="results/threshold.nc",
        code=[*code("figures/thresholds.py", "figures/curves.py"), *PLOT],
    output:
        pdf="results/figures/damage_boundary.pdf",
        png=report(
            "results/figures/damage_boundary.png",
            caption="workflow/report/damage_boundary.rst",
            category="Thresholds",
            labels={"figure": "damage boundary"},
        ),
    log:
        "results/logs/draw_damage_boundary.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw the damage boundary"
    script:
        "workflow/scripts/draw_damage_boundary.py"


rule draw_statics:
    input:
        statics="results/statics.nc",
        code=[*code("figures/statics.py"), *PLOT],
    output:
        pdf="results/figures/statics.pdf",
        png=report(
            "results/figures/statics.png",
            caption="workflow/report/statics.rst",
            category="Device",
            labels={"figure": "force and energy of the beam"},
        ),
    log:
        "results/logs/draw_statics.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw the beam's force and energy"
    script:
        "workflow/scripts/draw_statics.py"


rule simulate_history:
    input:
        code=[*SOLVER, *code("cells.py", "history.py", "provenance.py")],
    output:
        history="results/histories/{cell}.nc",
    log:
        "results/logs/simulate_history_{cell}.log",
    conda:
        "workflow/envs/snapmap.yaml"
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
        code=[*code("figures/histories.py"), *PLOT],
    output:
        pdf="results/figures/history_{cell}.pdf",
        png=report(
            "results/figures/history_{cell}.png",
            caption="workflow/report/history.rst",
            category="Histories",
            labels={"figure": "{cell}"},
        ),
    log:
        "results/logs/draw_history_{cell}.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw the history of {wildcards.cell}"
    script:
        "workflow/scripts/draw_history.py"


rule trace_cells:
    input:
        cube="results/cube.nc",
        code=[
            *SOLVER,
            *code(
                *["cells.py", "protocol.py", "thresholds.py", "ladder.py"],
                *["outcome.py", "grid.py", "cube.py", "traces.py"],
                *["provenance.py", "atomic.py"],
            ),
        ],
    output:
        traces="results/traces.nc",
    log:
        "results/logs/trace_cells.log",
    conda:
        "workflow/envs/snapmap.yaml"
    threads: 4
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
    params:
        device=asdict(study.device),
        model=study.model,
        protocol=study.protocol._asdict(),
    message:
        "Trace the motion of the cells of {input.cube}"
    script:
        "workflow/scripts/trace_cells.py"


rule write_page:
    input:
        cube="results/cube.nc",
        traces="results/traces.nc",
        code=[*code("figures/explore.*", "figures/maps.py", "figures/curves.py"), *PLOT],
    output:
        page="results/explore.html",
    log:
        "results/logs/write_page.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Write the page to explore {input.cube}"
    script:
        "workflow/scripts/write_page.py"


rule accuracy:
    input:
        "results/accuracy.nc",
        expand(
            "results/figures/{stem}.{kind}",
            stem=["accuracy", "convergence"],
            kind=["pdf", "png"],
        ),


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
    log:
        "results/logs/measure_accuracy{size}.log",
    conda:
        "workflow/envs/snapmap.yaml"
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
        code=[*code("figures/accuracy.py"), *PLOT],
    output:
        pdf="results/figures/accuracy{size}.pdf",
        png=report(
            "results/figures/accuracy{size}.png",
            caption="workflow/report/accuracy.rst",
            category="Accuracy",
            labels={"figure": "error over time{size}"},
        ),
    log:
        "results/logs/draw_accuracy{size}.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw error against time: {output.pdf}"
    script:
        "workflow/scripts/draw_accuracy.py"


rule draw_convergence:
    input:
        accuracy="results/accuracy.nc",
        code=[*code("figures/convergence.py", "figures/accuracy.py"), *PLOT],
    output:
        pdf="results/figures/convergence.pdf",
        png=report(
            "results/figures/convergence.png",
            caption="workflow/report/convergence.rst",
            category="Accuracy",
            labels={"figure": "error over number and step"},
        ),
    log:
        "results/logs/draw_convergence.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw error over number and step"
    script:
        "workflow/scripts/draw_convergence.py"


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
    log:
        "results/logs/measure_stability.log",
    conda:
        "workflow/envs/snapmap.yaml"
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
    log:
        "results/logs/measure_settled.log",
    conda:
        "workflow/envs/snapmap.yaml"
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
        code=[*code("figures/stability.py"), *PLOT],
    output:
        pdf="results/figures/stability.pdf",
        png=report(
            "results/figures/stability.png",
            caption="workflow/report/stability.rst",
            category="Stability",
            labels={"figure": "hard cases"},
        ),
    log:
        "results/logs/draw_stability.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Draw the hard cases"
    script:
        "workflow/scripts/draw_stability.py"


rule draw_settled:
    input:
        settled="results/settled.nc",
        code=[*code("figures/maps.py", "figures/curves.py"), *PLOT],
    output:
        pdf="results/figures/settled.pdf",
        png=report(
            "results/figures/settled.png",
            caption="workflow/report/settled.rst",
            category="Stability",
            labels={"figure": "what has settled"},
        ),
    log:
        "results/logs/draw_settled.log",
    conda:
        "workflow/envs/snapmap.yaml"
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
    log:
        "results/logs/write_stability_table.log",
    conda:
        "workflow/envs/snapmap.yaml"
    message:
        "Write the tables of docs/stability.md"
    script:
        "workflow/scripts/write_stability_table.py"
