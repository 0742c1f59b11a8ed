rule accuracy:
    input:
        "results/accuracy.nc",
        "results/accuracy.md",
        expand(
            "results/figures/{stem}.{kind}",
            stem=["accuracy", "convergence"],
            kind=["pdf", "png"],
        ),


rule measure_accuracy:
    output:
        accuracy="results/accuracy{size}.nc",
    log:
        "results/logs/measure_accuracy{size}.log",
    # All there are: another job at the same time would spoil the times.
    threads: 1000
    params:
        code=code("measure_accuracy"),
        device=values_of(nominal(study.device)),
        pulse=study.pulse,
        axes={key: study.axes[key].tolist() for key in ("C", "f0", "N")},
        settings=study.settings.asked(),
        plan=lambda wildcards: "quick" if wildcards.size else "full",
    message:
        "Measure error and time of every model: {output.accuracy}"
    script:
        "../scripts/measure_accuracy.py"


rule write_accuracy_table:
    input:
        accuracy="results/accuracy.nc",
    output:
        table="results/accuracy.md",
    log:
        "results/logs/write_accuracy_table.log",
    params:
        code=code("write_accuracy_table"),
    message:
        "Write the tables of docs/accuracy.md"
    script:
        "../scripts/write_accuracy_table.py"


rule draw_accuracy:
    input:
        accuracy="results/accuracy{size}.nc",
    output:
        pdf="results/figures/accuracy{size}.pdf",
        png=report(
            "results/figures/accuracy{size}.png",
            caption="../report/accuracy.rst",
            category="9 Accuracy",
            labels={"figure": "error over time{size}"},
        ),
    log:
        "results/logs/draw_accuracy{size}.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_accuracy"),
    message:
        "Draw error against time: {output.pdf}"
    script:
        "../scripts/draw_accuracy.py"


rule draw_convergence:
    input:
        accuracy="results/accuracy.nc",
    output:
        pdf="results/figures/convergence.pdf",
        png=report(
            "results/figures/convergence.png",
            caption="../report/convergence.rst",
            category="9 Accuracy",
            labels={"figure": "error over number and step"},
        ),
    log:
        "results/logs/draw_convergence.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_convergence"),
    message:
        "Draw error over number and step"
    script:
        "../scripts/draw_convergence.py"
