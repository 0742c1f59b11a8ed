import os
import sys
from dataclasses import asdict
from pathlib import Path

import platformdirs
from snakemake.exceptions import WorkflowError

# Jobs inherit both: nothing is written beside the code, and a kernel is compiled once per user.
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
os.environ.setdefault("NUMBA_CACHE_DIR", str(platformdirs.user_cache_path("snapmap") / "numba"))
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
    *["device.py", "bases/*.py", "modal.py", "wells.py", "models.py", "lanes.py", "reference.py"]
)


wildcard_constraints:
    slab="[0-9a-f]+",
    damping="[^/]+",
    cell="[^/]+",


rule all:
    input:
        "results/cube.nc",
        expand("results/figures/map_C{damping}.{kind}", damping=dampings, kind=["pdf", "png"]),
        expand("results/figures/history_{cell}.{kind}", cell=cells, kind=["pdf", "png"]),


rule simulate_slab:
    message:
        "Simulate slab {wildcards.slab}"
    input:
        code=[*SOLVER, *code(
            *["cells.py", "protocol.py", "thresholds.py", "ladder.py"],
            *["outcome.py", "grid.py", "slab.py"],
        )],
    output:
        slab="results/slabs/{slab}.nc",
    params:
        device=asdict(study.device),
        model=study.model,
        axes=lambda wildcards: slabs[wildcards.slab]._asdict(),
        protocol=study.protocol._asdict(),
    threads: 1
    script:
        "workflow/scripts/simulate_slab.py"


rule collect:
    message:
        "Collect {input.slabs} into one cube"
    input:
        slabs=[f"results/slabs/{name}.nc" for row in names for name in row],
        code=code("cube.py", "provenance.py"),
    output:
        cube="results/cube.nc",
    params:
        names=names,
        config=config,
    script:
        "workflow/scripts/collect.py"


rule draw_map:
    message:
        "Draw the map for C = {wildcards.damping} uN us/um"
    input:
        cube="results/cube.nc",
        code=code("figures/maps.py", "figures/style.py", "figures/paper.mplstyle", "quantity.py"),
    output:
        pdf="results/figures/map_C{damping}.pdf",
        png="results/figures/map_C{damping}.png",
    params:
        damping_index=lambda wildcards: dampings.index(wildcards.damping),
    script:
        "workflow/scripts/draw_map.py"


rule simulate_history:
    message:
        "Follow one cell in full: {wildcards.cell}"
    input:
        code=[*SOLVER, *code("cells.py", "history.py", "provenance.py")],
    output:
        history="results/histories/{cell}.nc",
    params:
        device=asdict(study.device),
        model=study.model,
        cell=lambda wildcards: cells[wildcards.cell]._asdict(),
        horizon=study.protocol.horizon,
    script:
        "workflow/scripts/simulate_history.py"


rule draw_history:
    message:
        "Draw the history of {wildcards.cell}"
    input:
        history="results/histories/{cell}.nc",
        code=code("figures/histories.py", "figures/style.py", "figures/paper.mplstyle", "quantity.py"),
    output:
        pdf="results/figures/history_{cell}.pdf",
        png="results/figures/history_{cell}.png",
    script:
        "workflow/scripts/draw_history.py"
