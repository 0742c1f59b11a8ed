def half(wildcards):
    """Half of the cores, so that other jobs go on beside one that could use them all.

    On a cluster, half of what a job may have: `cores` in profiles/slurm.
    """
    return max(1, cores // 2)


def memory(megabytes):
    return lambda wildcards, attempt: attempt * megabytes


def own_points(wildcards):
    """Path and hash of a user's own points: a function, as a path may have braces."""
    return list(study.own_points)


def views(several):
    return [view._asdict() for view in several]


def list_products(jobid):
    """Slabs stay, as a grid may grow again, and studies, which no config asks for."""
    if jobs[jobid].rule.name not in ("simulate_slab", *STUDIES):
        list_made("results", map(str, jobs[jobid].output))


def remove_old_products():
    """Of older configs; only a run of all results knows what is one."""
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


def constant(value):
    """A function, as a path in a value may have braces."""
    return lambda wildcards: value


def figures_of(name):
    """Figures of an application, as the report shows them."""
    application = attached()[name]
    caption = str(Path(application.__file__).with_name("caption.rst"))
    for stem in drawing_of[name]:
        paths = [f"results/figures/{stem}.{ending}" for ending in ("png", "pdf")]
        shown, *others = paths if "." not in stem else [f"results/{stem}"]
        labels = {"figure": stem}
        yield report(shown, caption, category=application.part, labels=labels)
        yield from others


def figures(caption):
    for stem in made.stems[caption]:
        png, pdf = [f"results/figures/{stem}.{ending}" for ending in ("png", "pdf")]
        labels = {"figure": stem}
        yield report(
            png, f"../report/{caption}.rst", category=PARTS[caption], labels=labels
        )
        yield pdf


def called(name):
    """How an application draws: its figures, and the rest that its function takes, by name."""
    files = drawn_from(name).items()
    paths = {
        f"{key}_{'path' if isinstance(f, str) else 'paths'}": f for key, f in files
    }
    folder = str(Path(next(figures_of(name))).parent)
    return drawing_of[name], paths | {"folder": folder}


def is_drawn_with_the_study(name):
    """Whether all that it is drawn from is there with cube and thresholds."""
    files = drawn_from(name).values()
    paths = [path for f in files for path in ([f] if isinstance(f, str) else f)]
    return {*paths} <= {"results/cube.nc", "results/threshold.nc", *made_quickly}
