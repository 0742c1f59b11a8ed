# Products that are there are held to what this run would make: what belongs to another study or code
# is made again. Neither Snakemake's times nor its metadata outlive a copy.

makers = list(workflow.rules)
single = [maker for maker in makers if not maker.has_wildcards()]
by_path = {str(path): maker for maker in single for path in maker.output}
inputs = {path: [*map(str, maker.input)] for path, maker in by_path.items()}

# The hash of what each product is made from, by path, after those of its inputs.
made_from = {f"results/slabs/{name}.nc": made.hash_of(numbers, name) for name in slabs}
for path in filter(by_path.get, TopologicalSorter(inputs).static_order()):
    given = by_path[path].params.items()
    params = {key: v(None) if callable(v) else v for key, v in given}
    made_from[path] = made.hash_of(params, [made_from[file] for file in inputs[path]])
for maker in single:  # its job lists its products by it
    maker.set_params(made_from=made_from[str(maker.output[0])])

results = [*inputs]


def force_others(wildcards):
    """Give no inputs, but let Snakemake make others again, wherever a job asks for its inputs."""
    workflow.dag.forcefiles.update(others)
    return []


others = []
if workflow.is_main_process:
    others = made.find_others(made_from)
    if others:
        tell(made.say_why(others))
        for maker in makers:
            maker.set_input(force_others)
    right = [path for path in made_from if path not in others]
    made.mend_times({path: inputs.get(path, ()) for path in right})
    atexit.register(finish, os.getcwd())

# The cells of each slab that is not there or is made again, by its name.
new_cells = {
    name: cells_in(slabs[name])
    for name, path in zip(slabs, cells_are_in)
    if path in others or not os.path.exists(path)
}
progress = Progress(new_cells)
