rule simulate_slab:
    output:
        slab="results/slabs/{slab}.nc",
    log:
        "results/logs/simulate_slab_{slab}.log",
    priority: 100
    retries: 1
    threads: 1
    resources:
        mem_mb=lambda wildcards, attempt: attempt * requests[wildcards.slab].mem_mb,
        runtime=lambda wildcards, attempt: attempt * requests[wildcards.slab].runtime,
    params:
        code=code("simulate_slab"),
        study=study.values(),
        axes=lambda wildcards: slabs[wildcards.slab],
    message:
        "Simulate the cells"
    script:
        "../scripts/simulate_slab.py"


rule collect:
    input:
        slab=[f"results/slabs/{name}.nc" for name in slabs],
    output:
        cube="results/cube.nc",
    log:
        "results/logs/collect.log",
    priority: 90
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
    params:
        code=code("collect"),
        axes={key: values.tolist() for key, values in study.axes.items()},
        config=study.document(),
    message:
        "Join the slabs to one cube"
    script:
        "../scripts/collect.py"
