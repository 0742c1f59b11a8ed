rule find_threshold:
    output:
        threshold=update("results/threshold.nc"),
        table="results/thresholds.csv",
    log:
        "results/logs/find_threshold.log",
    # Beside the first cells, not after them: of these no two then compile the same kernel at once.
    priority: 110
    threads: half
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
    params:
        code=code("find_threshold"),
        study=study.values(*THRESHOLD_SETTINGS),
        axes={
            key: values.tolist()
            for key, values in study.axes.items()
            if key not in ("device", "shape", "direction", "N")
        },
        tolerance=study.threshold_tolerance,
        highest=float(study.axes["N"][-1]),
    message:
        "Find the thresholds"
    script:
        "../scripts/find_threshold.py"


rule draw_thresholds:
    input:
        threshold="results/threshold.nc",
    output:
        pdf=[f"results/figures/{stem}.pdf" for stem in made.curve_stems],
        png=[
            report(
                f"results/figures/{stem}.png",
                caption="../report/thresholds.rst",
                category="2 Thresholds",
                labels={"figure": stem},
            )
            for stem in made.curve_stems
        ],
    log:
        "results/logs/draw_thresholds.log",
    priority: 60
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_thresholds"),
        views=[view._asdict() for view in study.curves],
        boundary=study.boundary._asdict(),
    message:
        "Draw the thresholds"
    script:
        "../scripts/draw_thresholds.py"
