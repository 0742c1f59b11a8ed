def half(wildcards):
    """Give half of the cores, so that other jobs go on beside one that could use them all.

    On a cluster it is half of the cores that a job may have: `cores` in profiles/slurm.
    """
    return max(1, cores // 2)


def memory(megabytes):
    return lambda wildcards, attempt: attempt * megabytes


def list_products(jobid):
    """List the products of a job, but of no study."""
    if jobs[jobid].rule.name not in STUDIES:
        paths = map(str, jobs[jobid].output)
        list_made({path: made_from[path] for path in paths})


def list_finished():
    """List the products of all jobs that ran: with --quiet, none is announced as it ends."""
    for jobid, job in jobs.items():
        if workflow.dag.needrun(job) and workflow.dag.finished(job):
            list_products(jobid)


def remove_old_products():
    """Remove products of older configs; only a run of all results can tell which these are."""
    products = {str(path) for job in workflow.dag.jobs for path in job.output}
    if products.issuperset(results):
        for line in remove_others(products):
            print(line, file=sys.stderr)


def find_missing_cells():
    """Find the slabs that are not there or are made again; returns their cells by their names."""
    running = list(filter(workflow.dag.needrun, workflow.dag.jobs))
    again = {job.wildcards.slab for job in running if job.rule.name == CELLS}
    if any(job.rule.name == ALL_CELLS for job in running):
        again = {*names}
    again |= new | {name for name in names if cells_are_in.format(name) in others}
    return {name: cells_in(slabs[name]) for name in names if name in again}


def say_cells():
    """Print how many cells there are, and how many of them are new."""
    missing, cells = sum(find_missing_cells().values()), sum(map(cells_in, plan.slabs))
    print(
        f"{cells} cells: {cells - missing} are there already, {missing} are new",
        file=sys.stderr,
    )


def tidy_when_idle():
    with suppress(OSError):  # another run is at work, or it is another user's folder
        if not workflow.dryrun:
            hold(".snakemake/running")
            remove_old_products()


def kept(outputs):
    """Let outputs by name stay until a job replaces them; Snakemake would remove them before it."""
    return {
        name: (
            update(files)
            if isinstance(files, str)
            else [update(path) for path in files]
        )
        for name, files in outputs.items()
    }


def constant(value):
    """Make a parameter of a value that may have braces, which Snakemake would format."""
    return lambda wildcards: value


def listed(files):
    """List the paths of files by name, each of which may be several."""
    return [path for f in files.values() for path in ([f] if isinstance(f, str) else f)]


def files_of(name, caption, category, folder="results/figures", endings=("png", "pdf")):
    """List the files of a figure, of which the report shows the first."""
    paths = [f"{folder}/{name}.{ending}" for ending in endings]
    shown = report(paths[0], caption, category=category, labels={"figure": name})
    return [shown, *paths[1:]]


def figures_of(name):
    """List the files of all figures of an application."""
    part = attached()[name]
    caption = Path(getfile(type(part))).with_name("caption.rst")
    about = str(caption), part.part, part.saved_in, part.endings
    return [path for figure in drawing_of[name] for path in files_of(figure, *about)]


def figures(caption):
    """List the files of the core's figures that share a caption."""
    about = f"../report/{caption}.rst", PARTS[caption]
    return [path for stem in views.stems[caption] for path in files_of(stem, *about)]


def is_drawn_with_the_study(name):
    """Tell whether all files behind an application's figures exist with cube and thresholds."""
    paths = {*listed(attached()[name].drawn_from(study))}
    return paths <= {"results/cube.nc", "results/threshold.nc", *made_quickly}
