import json
import os
import sys
from contextlib import suppress
from dataclasses import replace
from inspect import getfile
from pathlib import Path

from snakemake.logging import logger
from snakemake.utils import min_version

min_version("9.19")

# Nothing is written beside the code. Scripts import the package by the same name, as numba's cache
# asks for it by name.
sys.dont_write_bytecode = True
clone = Path(workflow.current_basedir.get_path_or_uri(secret_free=True))
scripts = clone / "workflow" / "scripts"
sys.path.insert(0, str(scripts))  # before what PYTHONPATH names
# Jobs inherit these, and import no module from the folder of the study or from another clone.
paths = [str(scripts), *filter(None, [os.getenv("PYTHONPATH")])]
os.environ.update(
    PYTHONPATH=os.pathsep.join(paths), PYTHONDONTWRITEBYTECODE="1", PYTHONSAFEPATH="1"
)
from snapmap.files.atomic import hold, refuse_others, remove_leftovers
from snapmap.workflow.job_log import SHELL_PREFIX
from snapmap.workflow.made import (
    find_others,
    forget,
    hash_of,
    list_made,
    mend_times,
    remove_others,
    say_why,
)
from snapmap.files.named import hold_to_plan, plan_with
from snapmap.workflow.progress import (
    ALL_CELLS,
    CELLS,
    DRY_RUN,
    NOTHING,
    Hook,
    Progress,
    hush,
)
from snapmap.study.provenance import (
    NUMBERS,
    code_hash,
    device_sections,
    hash_drawing,
    hash_numbers,
)
from snapmap.applications import attached, gather, refuse_all
from snapmap.config.devices import nominal
from snapmap.applications.whole import doubts, files_of, load_config
from snapmap.config.doubts import descriptions
from snapmap.workflow.products import choose_views
from snapmap.config.yaml_file import read_document
from snapmap.device.device import VALUES
from snapmap.study.study import OF_THRESHOLDS
from snapmap.workflow.plan import SHARED_SECONDS, make_plan
from snapmap.sweeps.slabs import cells_in, slab_name

if not workflow.overwrite_configfiles:

    default = Path("config/config.yaml")  # of the folder of the run, if it has one

    configfile: default if default.exists() else clone / default


# A report runs no job, and needs no --cores.
cores = 1 if workflow.resource_settings.cores is None else workflow.cores
if cores < 1:
    sys.exit(f"--cores {cores}: no job would ever start; write 1 or more")
if not os.access(".", os.W_OK):
    sys.exit(f"{os.getcwd()}: cannot be written to; run in a folder of your own")
try:
    for path in workflow.overwrite_configfiles:
        read_document(path)  # Snakemake keeps the last of two equal keys without a word
    refuse_others("results", [".nc", ".csv", ".md", ".html", ".pdf", ".png"])
    study = load_config(config)
    # Parameters of the rules, by which products of other code are made again.
    code = hash_numbers(scripts / "jobs.py") | hash_drawing(scripts / "draw.py")
    if workflow.is_main_process:
        plan_with(files_of(study) | code)
    hold_to_plan(files_of(study))
    plan = make_plan(study)
    warnings = doubts(study)
    if workflow.is_main_process:
        refuse_all(study)
except ValueError as error:
    sys.exit(str(error))  # Snakemake would put words of its own around it

shell.prefix(SHELL_PREFIX)
# Snakemake would import pandas to see that no parameter is a table: a sixth of its start.
sys.modules.setdefault("pandas", None)

names = [slab_name(study, slab) for slab in plan.slabs]
slabs = dict(zip(names, plan.slabs))
# A small study is one job, as the start of another would take longer than the cells.
is_small = len(slabs) == 1 and plan.seconds <= SHARED_SECONDS
requests = dict(zip(names, plan.requests))
views = choose_views(study)
cells_are_in = "results/cube.nc" if is_small else "results/slabs/{}.nc"
new = {name for name in names if not os.path.exists(cells_are_in.format(name))}
numbers, drawing = code.values()
studied = code_hash(*NUMBERS, clone / "studies")
# Rules whose summaries are printed at the end.
SUMMARIZED = ["find_threshold", "collect", "simulate_all"]
jobs = {}  # jobs of the run by their numbers


report: "workflow/report/study.rst"


wildcard_constraints:
    slab="[0-9a-f_]+",
    cell="[^/]+",


onstart:
    # Snakemake's own lock, which the profile turns off, outlives a killed run; this one does not.
    try:
        unlocked = hold(".snakemake/running")
    except BlockingIOError:
        sys.exit(f"{os.getcwd()}: another run is at work in this folder")
    if unlocked:
        print(
            f"{os.getcwd()}: cannot be locked ({unlocked}); start no second run here",
            file=sys.stderr,
        )
    remove_leftovers("results")
    for line in filter(None, [*descriptions(study), study.left_out, *warnings]):
        print(line, file=sys.stderr)
    running = list(workflow.dag.needrun_jobs())
    forget({str(path) for job in running for path in job.output})
    progress.cells = find_missing_cells()
    if sum(progress.cells.values()) < sum(map(cells_in, plan.slabs)):
        say_cells()
    for handler in logger.handlers:
        if handler.name == "DefaultStreamHandler":
            hush(handler)
    jobs.update({workflow.dag.jobid(job): job for job in workflow.dag.jobs})
    logger.addHandler(progress)
    progress.begin()


onerror:
    progress.close()
    list_finished()


onsuccess:
    progress.close()
    list_finished()
    remove_old_products()
    logs = {job.rule.name: job.log[0] for job in jobs.values() if job.log}
    for log in [logs[rule] for rule in SUMMARIZED if rule in logs]:
        # The last line is the summary; warnings have been printed already.
        if summary := Path(log).read_text(encoding="utf-8").splitlines()[-1:]:
            print(*summary, file=sys.stderr)
    if any("results/explore.html" in job.output for job in jobs.values()):
        print("results/explore.html: open it in a browser", file=sys.stderr)


include: "workflow/rules/common.smk"


progress = Progress({name: cells_in(slabs[name]) for name in new}, list_products)
if workflow.is_main_process:
    logger.addHandler(Hook(NOTHING, tidy_when_idle))
    logger.addHandler(Hook(DRY_RUN, say_cells))


include: "workflow/rules/applications.smk"
include: "workflow/rules/run.smk"
include: "workflow/rules/draw.smk"
include: "workflow/rules/studies.smk"
include: "workflow/rules/made.smk"


rule all:
    input:
        results,
