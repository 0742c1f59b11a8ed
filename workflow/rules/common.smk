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
        list_made("results", {path: made_from[path] for path in paths})


def remove_old_products():
    """Remove products of older configs; only a run of all results can tell which these are."""
    products = {str(path) for job in workflow.dag.jobs for path in job.output}
    if products.issuperset(results):
        for line in remove_others("results", products):
            print(line, file=sys.stderr)


def tidy_when_idle():
    with suppress(OSError):  # another run is at work, or it is another user's folder
        if not workflow.dryrun:
            hold(".snakemake/running")
            remove_old_products()


def drawn_from(name):
    application = attached()[name]
    if hasattr(application, "drawn_from"):
        return application.drawn_from(study)
    return application.outputs(study)


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


def files_of(stem, caption, category):
    """List the files of a figure, of which the report shows the first."""
    paths = [f"results/figures/{stem}.{ending}" for ending in ("png", "pdf")]
    first, *others = paths if "." not in stem else [f"results/{stem}"]
    shown = report(first, caption, category=category, labels={"figure": stem})
    return [shown, *others]


def figures_of(name):
    """List the files of all figures of an application."""
    application = attached()[name]
    about = str(Path(application.__file__).with_name("caption.rst")), application.part
    return [path for stem in drawing_of[name] for path in files_of(stem, *about)]


def figures(caption):
    """List the files of the core's figures that share a caption."""
    about = f"../report/{caption}.rst", PARTS[caption]
    return [path for stem in views.stems[caption] for path in files_of(stem, *about)]


def drawing_arguments(name):
    """Give the figures of an application, and the other arguments of its function by name."""
    files = drawn_from(name).items()
    paths = {
        f"{key}_{'path' if isinstance(f, str) else 'paths'}": f for key, f in files
    }
    folder = str(Path(figures_of(name)[0]).parent)
    return drawing_of[name], paths | {"folder": folder}


def is_drawn_with_the_study(name):
    """Tell whether all files behind an application's figures exist with cube and thresholds."""
    files = drawn_from(name).values()
    paths = [path for f in files for path in ([f] if isinstance(f, str) else f)]
    return {*paths} <= {"results/cube.nc", "results/threshold.nc", *made_quickly}
