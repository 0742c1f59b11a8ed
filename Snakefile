import atexit
import json
import os
import sys
from contextlib import suppress
from functools import partial
from graphlib import TopologicalSorter
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
# Jobs inherit these: they import no module from the folder of the study or from another clone, and
# draw to files, though a notebook that starts the run has a backend of its own.
paths = [str(scripts), *filter(None, [os.getenv("PYTHONPATH")])]
os.environ |= {"PYTHONPATH": os.pathsep.join(paths), "MPLBACKEND": "agg"}
os.environ |= dict.fromkeys(("PYTHONDONTWRITEBYTECODE", "PYTHONSAFEPATH"), "1")
from snapmap.applications import attached, gather, refuse_all
from snapmap.applications.whole import doubts, files_of, load_config
from snapmap.config.doubts import descriptions
from snapmap.config.yaml_file import read_document
from snapmap.files.atomic import hold, remove_leftovers
from snapmap.files.named import hold_to_plan, plan_with
from snapmap.study import provenance
from snapmap.study.study import OF_THRESHOLDS
from snapmap.sweeps.slabs import cells_in, slab_name
from snapmap.workflow import made
from snapmap.workflow.job_log import SHELL_PREFIX
from snapmap.workflow.plan import SHARED_SECONDS, make_plan
from snapmap.workflow.plan import choose_views
from snapmap.workflow.progress import ALL_CELLS, CELLS, Progress

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
    study = load_config(config)
    # Parameters of the rules, by which products of other code are made again.
    code = provenance.hash_numbers(scripts / "jobs.py")
    code |= provenance.hash_drawing(scripts / "draw.py")
    if workflow.is_main_process:
        plan_with(files_of(study) | code)
    hold_to_plan(files_of(study))
    plan = make_plan(study)
    warnings = doubts(study)
    if workflow.is_main_process:
        refuse_all(study)
except ValueError as error:
    sys.exit(str(error))  # Snakemake would put words of its own around it

tell = partial(print, file=sys.stderr)
shell.prefix(SHELL_PREFIX)
# Snakemake would import pandas to see that no parameter is a table: a sixth of its start.
sys.modules.setdefault("pandas", None)

slabs = {slab_name(study, slab): slab for slab in plan.slabs}
requests = dict(zip(slabs, plan.requests))
# A small study is one job, as the start of another would take longer than the cells.
is_small = len(slabs) == 1 and plan.seconds <= SHARED_SECONDS
views = choose_views(study)
numbers, drawing = code.values()


report: "workflow/report/study.rst"


include: "workflow/rules/common.smk"


# A job reads the config itself. Its params are plain values on which its output depends: Snakemake
# runs the job again when they change.
in_search = study.inputs(*OF_THRESHOLDS)
axes = {key: values.tolist() for key, values in study.axes.items()}
making = gather(lambda part: part.outputs(study))
drawing_of = gather(lambda part: part.drawn(study))
quick = {name: files for name, files in making.items() if attached()[name].quick}
slow = [name for name in making if name not in quick]
made_quickly = [path for files in quick.values() for path in listed(files)]
summarized = ["find_threshold", "collect", "simulate_all"]
summarized += [attached()[name].rule for name in slow]


onstart:
    # Snakemake's own lock, which the profile turns off, outlives a killed run; this one does not.
    try:
        unlocked = hold(".snakemake/running")
    except BlockingIOError:
        sys.exit(f"{os.getcwd()}: another run is at work in this folder")
    if unlocked:
        tell(
            f"{os.getcwd()}: cannot be locked ({unlocked}); start no second run here"
        )
    remove_leftovers("results")
    for line in filter(None, [*descriptions(study), study.left_out, *warnings]):
        tell(line)
    made.begin_list()
    for handler in logger.handlers:
        if handler.name == "DefaultStreamHandler":
            handler.addFilter(progress.is_shown)
    logger.addHandler(progress)
    progress.begin()


onerror:
    progress.close()


onsuccess:
    progress.close()
    remove_old_products()
    logs = {job.rule.name: job.log[0] for job in workflow.dag.jobs if job.log}
    for log in [logs[rule] for rule in summarized if rule in logs]:
        # Its last line; warnings have been printed already.
        if summary := Path(log).read_text(encoding="utf-8").splitlines()[-1:]:
            tell(*summary)
    if any("results/explore.html" in job.output for job in workflow.dag.jobs):
        tell("results/explore.html: open it in a browser")


include: "workflow/rules/run.smk"
include: "workflow/rules/applications.smk"
include: "workflow/rules/draw.smk"
include: "workflow/rules/made.smk"


rule all:
    input:
        results,
