rule simulate_history:
    input:
        recorded,
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
        "Follow one cell in full: {wildcards.cell}"
    script:
        "../scripts/simulate_history.py"


rule draw_history:
    input:
        history="results/histories/{cell}.nc",
    output:
        pdf="results/figures/history_{cell}.pdf",
        png=report(
            "results/figures/history_{cell}.png",
            caption="../report/history.rst",
            category="Histories",
            labels={"figure": "{cell}"},
        ),
    log:
        "results/logs/draw_history_{cell}.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_history"),
    message:
        "Draw the history of {wildcards.cell}"
    script:
        "../scripts/draw_history.py"
