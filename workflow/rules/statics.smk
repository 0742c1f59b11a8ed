rule trace_statics:
    output:
        statics="results/statics.nc",
    log:
        "results/logs/trace_statics.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("trace_statics"),
        device=asdict(study.device),
    message:
        "Push the beam slowly through"
    script:
        "../scripts/trace_statics.py"


rule draw_statics:
    input:
        statics="results/statics.nc",
    output:
        pdf="results/figures/statics.pdf",
        png=report(
            "results/figures/statics.png",
            caption="../report/statics.rst",
            category="Device",
            labels={"figure": "force and energy of the beam"},
        ),
    log:
        "results/logs/draw_statics.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_statics"),
    message:
        "Draw the beam's force and energy"
    script:
        "../scripts/draw_statics.py"
