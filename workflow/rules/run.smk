if is_small:
    cells_are_in = ["results/cube.nc"]

    rule simulate_all:
        output:
            cube="results/cube.nc",
        log:
            "results/logs/simulate_all.log",
        priority: 100
        # With no core of its own it runs beside the search, as its cells take less than its start.
        threads: lambda wildcards: int(workflow.non_local_exec)
        resources:
            mem_mb=memory(2000),
        params:
            code=numbers,
            axes=plan.slabs[0],
            inputs=study.inputs(),
        message:
            "Simulate the cells"
        script:
            "../scripts/jobs.py"

else:
    cells_are_in = [f"results/slabs/{name}.nc" for name in slabs]

    rule simulate_slab:
        output:
            slab="results/slabs/{slab,[0-9a-f_]+}.nc",
        log:
            "results/logs/simulate_slab_{slab}.log",
        priority: 100
        retries: 1
        threads: 1
        resources:
            mem_mb=lambda wildcards, attempt: attempt * requests[wildcards.slab].mem_mb,
            runtime=lambda wildcards, attempt: attempt
            * requests[wildcards.slab].runtime,
        params:
            code=numbers,
            axes=lambda wildcards: slabs[wildcards.slab],  # all else is in its name
            made_from=lambda wildcards: made.hash_of(numbers, wildcards.slab),
        message:
            "Simulate the cells"
        script:
            "../scripts/jobs.py"

    rule collect:
        input:
            slab=cells_are_in,
        output:
            cube="results/cube.nc",
        log:
            "results/logs/collect.log",
        priority: 90
        resources:
            mem_mb=memory(2000),
        params:
            code=numbers,
            axes=axes,
            inputs=study.document(),
        message:
            "Join the slabs to one cube"
        script:
            "../scripts/jobs.py"


rule find_threshold:
    output:
        **kept(
            {
                "threshold": "results/threshold.nc",
                "table": "results/thresholds.csv",
                "others": made_quickly,
            }
        ),
    log:
        "results/logs/find_threshold.log",
    # The search begins with the first cells: so no two jobs of cells compile a kernel at once.
    priority: 110
    threads: cores if is_small and not slow else half
    resources:
        mem_mb=memory(2000),
    params:
        code=numbers,
        inputs=in_search,
        axes=axes | {"N": axes["N"][-1]},
        tolerance=study.threshold_tolerance,
        quick=quick,
    message:
        "Find the thresholds"
    script:
        "../scripts/jobs.py"
