rule measure_integrity:
    input:
        cube="results/cube.nc",
    output:
        integrity="results/integrity.nc",
    log:
        "results/logs/measure_integrity.log",
    params:
        code=code("measure_integrity"),
    message:
        "Measure the integrity of the maps"
    script:
        "../scripts/measure_integrity.py"


rule draw_integrity:
    input:
        integrity="results/integrity.nc",
    output:
        pdf="results/figures/integrity.pdf",
        png=report(
            "results/figures/integrity.png",
            caption="../report/integrity.rst",
            category="3 When it snaps, where it ends",
            labels={"figure": "integrity of the maps"},
        ),
    log:
        "results/logs/draw_integrity.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_integrity"),
    message:
        "Draw the integrity of the maps"
    script:
        "../scripts/draw_integrity.py"
