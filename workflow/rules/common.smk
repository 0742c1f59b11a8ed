def half(wildcards):
    """Give half of the cores of this machine, or of `cores` in profiles/slurm, as others go on."""
    return max(1, cores // 2)


def memory(megabytes):
    return lambda wildcards, attempt: attempt * megabytes


def remove_old_products():
    """Remove products of older configs; only a run of all results can tell which these are."""
    products = {str(path) for job in workflow.dag.jobs for path in job.output}
    if products.issuperset(results):
        for line in made.remove_others(products):
            tell(line)


def finish(folder):
    """End a dry run with the number of new cells, and one that ran no job without old products."""
    if workflow.scheduler is None:  # a report or another question
        return
    os.chdir(folder)  # which --directory names for as long as Snakemake is at work
    if workflow.dryrun:
        cells, new = sum(map(cells_in, plan.slabs)), sum(new_cells.values())
        tell(f"{cells} cells: {cells - new} are there already, {new} are new")
    elif not any(map(workflow.dag.needrun, workflow.dag.jobs)):
        # Another run may be at work, or it is another user's folder.
        with suppress(OSError):
            hold(".snakemake/running")
            remove_old_products()


def kept(outputs):
    """Let outputs by name stay until a job replaces them; Snakemake would remove them before it."""
    return {name: update(files) for name, files in outputs.items()}


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
