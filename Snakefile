import fcntl
import os
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError

# Nothing is written beside the code. The package has the name that the scripts call it by, as what
# numba keeps in its cache asks for it by name.
sys.dont_write_bytecode = True
sys.path.append(str(Path(workflow.basedir) / "workflow" / "scripts"))
from snapmap.dependencies import code_hash, kernel_cache

# Jobs inherit both: a kernel is compiled once per user.
os.environ.update(PYTHONDONTWRITEBYTECODE="1")
os.environ.setdefault("NUMBA_CACHE_DIR", str(kernel_cache()))
from snapmap.atomic import remove_leftovers
from snapmap.config import load_study
from snapmap.document import read_document
from snapmap.partition import slab_name
from snapmap.plan import cut, requests

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


include: "workflow/rules/common.smk"
include: "workflow/rules/sweep.smk"
include: "workflow/rules/thresholds.smk"
include: "workflow/rules/statics.smk"
include: "workflow/rules/maps.smk"
include: "workflow/rules/histories.smk"
include: "workflow/rules/page.smk"
include: "workflow/rules/accuracy.smk"
include: "workflow/rules/stability.smk"


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
            ],
            kind=["pdf", "png"],
        ),
        "results/explore.html",
