rule stability:
    input:
        "results/stability.md",
        expand("results/figures/stability.{kind}", kind=["pdf", "png"]),
        expand("results/figures/settled.{kind}", kind=["pdf", "png"]),


rule measure_stability:
    output:
        stability="results/stability.nc",
    log:
        "results/logs/measure_stability.log",
    # All there are: no other rule takes as long.
    threads: 1000
    params:
        code=code("measure_stability"),
        device=values_of(nominal(study.device)),
    message:
        "Follow the hard cases"
    script:
        "../scripts/measure_stability.py"


rule measure_settled:
    output:
        settled="results/settled.nc",
    log:
        "results/logs/measure_settled.log",
    threads: 1000
    params:
        code=code("measure_settled"),
        device=values_of(nominal(study.device)),
        beam_dampings=[0.0, 4e-4, 4e-3],
    message:
        "Sweep with less and more damping"
    script:
        "../scripts/measure_settled.py"


rule draw_stability:
    input:
        stability="results/stability.nc",
    output:
        pdf="results/figures/stability.pdf",
        png=report(
            "results/figures/stability.png",
            caption="../report/stability.rst",
            category="9 Stability",
            labels={"figure": "hard cases"},
        ),
    log:
        "results/logs/draw_stability.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_stability"),
    message:
        "Draw the hard cases"
    script:
        "../scripts/draw_stability.py"


rule draw_settled:
    input:
        settled="results/settled.nc",
    output:
        pdf="results/figures/settled.pdf",
        png=report(
            "results/figures/settled.png",
            caption="../report/settled.rst",
            category="9 Stability",
            labels={"figure": "what has settled"},
        ),
    log:
        "results/logs/draw_settled.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_settled"),
        beam_dampings=[0.0, 4e-4],
        C=25.0,
    message:
        "Draw what is settled without and with damping of the beam"
    script:
        "../scripts/draw_settled.py"


rule write_stability_table:
    input:
        stability="results/stability.nc",
        settled="results/settled.nc",
    output:
        table="results/stability.md",
    log:
        "results/logs/write_stability_table.log",
    params:
        code=code("write_stability_table"),
    message:
        "Write the tables of docs/stability.md"
    script:
        "../scripts/write_stability_table.py"
