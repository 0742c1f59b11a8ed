rule simulate_history:
    output:
        history="results/histories/{cell}.nc",
    log:
        "results/logs/simulate_history_{cell}.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("simulate_history"),
        device=lambda wildcards: values_of(cells[wildcards.cell].device),
        pulse=study.pulse,
        model=study.model,
        cell=lambda wildcards: cells[wildcards.cell].shock,
        followed={key: asked[key] for key in ("horizon", "until", "energy_tolerance")},
    message:
        "Follow single cells in full"
    script:
        "../scripts/simulate_history.py"


rule draw_histories:
    input:
        histories=[f"results/histories/{cell}.nc" for cell in cells],
    output:
        pdf=[f"results/figures/history_{cell}.pdf" for cell in cells],
        png=[
            report(
                f"results/figures/history_{cell}.png",
                caption="../report/history.rst",
                category="Histories",
                labels={"figure": cell},
            )
            for cell in cells
        ],
    log:
        "results/logs/draw_histories.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_histories"),
    message:
        "Draw the histories"
    script:
        "../scripts/draw_histories.py"
