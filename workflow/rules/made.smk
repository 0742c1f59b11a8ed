# Products that are there are held to what this run would make: what belongs to another study or code
# is made again. Neither Snakemake's times nor its metadata outlive a copy.

# By path, after those that it is made from: the hash of what a product is made from, and its inputs.
made_from = {f"results/slabs/{name}.nc": made.hash_of(numbers, name) for name in slabs}
sources = dict.fromkeys(made_from, ())
makers = [maker for maker in workflow.rules if maker.name not in STUDIES]

for maker in makers:
    if not maker.has_wildcards():
        files = [str(file) for file in maker.input]
        given = maker.params.items()
        params = {key: v(None) if callable(v) else v for key, v in given}
        its_hash = made.hash_of(params, [made_from[file] for file in files])
        maker.set_params(made_from=its_hash)  # the job lists its products by it
        made_from |= dict.fromkeys(map(str, maker.output), its_hash)
        sources |= dict.fromkeys(map(str, maker.output), files)

results = [path for path in sources if not path.startswith(made.SLABS)]


def force_others(wildcards):
    """Give no inputs, but let Snakemake make others again, wherever a job asks for its inputs."""
    workflow.dag.forcefiles.update(others)
    return []


others = []
if workflow.is_main_process:
    others = made.find_others(made_from)
    if others:
        tell(made.say_why(others, study.document()))
        for maker in makers:
            maker.set_input(force_others)
    made.mend_times(
        {path: files for path, files in sources.items() if path not in others}
    )
    atexit.register(finish, os.getcwd())

# The cells of each slab that is not there or is made again, by its name.
new_cells = {
    name: cells_in(slabs[name])
    for name, path in zip(slabs, cells_are_in)
    if path in others or not os.path.exists(path)
}
progress = Progress(new_cells)
