rule simulate_history:
    output:
        history="results/histories/{cell}.nc",
    log:
        "results/logs/simulate_history_{cell}.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("simulate_history"),
        study=lambda wildcards: {
            **study.values("horizon", "until", "energy_tolerance"),
            "device": values_of(made.histories[wildcards.cell].device),
        },
        cell=lambda wildcards: made.histories[wildcards.cell].shock,
    message:
        "Follow single cells in full"
    script:
        "../scripts/simulate_history.py"


rule draw_histories:
    input:
        history=[f"results/histories/{cell}.nc" for cell in made.histories],
    output:
        pdf=[f"results/figures/history_{cell}.pdf" for cell in made.histories],
        png=[
            report(
                f"results/figures/history_{cell}.png",
                caption="../report/history.rst",
                category="8 Histories",
                labels={"figure": cell},
            )
            for cell in made.histories
        ],
    log:
        "results/logs/draw_histories.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_histories"),
    message:
        "Draw the histories"
    script:
        "../scripts/draw_histories.py"
