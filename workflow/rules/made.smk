# Products that are there are held to what this run would make: what belongs to another study or code
# is made again. Neither Snakemake's times nor its metadata outlive a copy.


def plan_products():
    """Hash what each product is made from: the params of its rule and, in turn, its inputs.

    Returns the hashes, and the inputs, by path; each product comes after its inputs.
    """
    makers = {
        str(path): maker
        for maker in workflow.rules
        if not maker.has_wildcards() and maker.name not in STUDIES
        for path in maker.output
    }
    hashes = {f"results/slabs/{name}.nc": hash_of(numbers, name) for name in slabs}
    sources = dict.fromkeys(hashes, ())

    def add(path):
        if path not in hashes:
            maker = makers[path]
            files = [str(file) for file in maker.input]
            given = maker.params.items()
            params = {key: v(None) if callable(v) else v for key, v in given}
            hashes[path] = hash_of(params, [add(file) for file in files])
            sources[path] = files
        return hashes[path]

    for path in makers:
        add(path)
    return hashes, sources


def force_others(wildcards):
    """Give no inputs, but let Snakemake make others again, wherever a job asks for its inputs."""
    workflow.dag.forcefiles.update(others)
    return []


made_from, sources = plan_products()
if workflow.is_main_process:
    others = find_others(made_from)
    if others:
        print(say_why(others, study.document()), file=sys.stderr)
        for maker in workflow.rules:
            if maker.name not in STUDIES:
                maker.set_input(force_others)
    mend_times({path: files for path, files in sources.items() if path not in others})
