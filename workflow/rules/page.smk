rule trace_cells:
    input:
        cube="results/cube.nc",
    output:
        traces=update("results/traces.nc"),
    log:
        "results/logs/trace_cells.log",
    priority: 65
    threads: half
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
    params:
        code=code("trace_cells"),
        study=study.values(),
    message:
        "Trace the motion of the cells"
    script:
        "../scripts/trace_cells.py"


rule write_page:
    input:
        **({"tolerance": "results/tolerance.nc"} if study.tolerances else {}),
        cube="results/cube.nc",
        traces="results/traces.nc",
        threshold="results/threshold.nc",
    output:
        page=report(
            "results/explore.html",
            caption="../report/page.rst",
            category="4 Page",
            labels={"page": "explore"},
        ),
    log:
        "results/logs/write_page.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("write_page"),
        horizon=study.settings.horizon,
    message:
        "Write the page"
    script:
        "../scripts/write_page.py"
