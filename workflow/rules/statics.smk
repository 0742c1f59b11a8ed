rule trace_statics:
    output:
        statics="results/statics{which}.nc",
    log:
        "results/logs/trace_statics{which}.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("trace_statics"),
        device=lambda wildcards: values_of(made.statics[wildcards.which]),
    message:
        "Push the beam slowly through"
    script:
        "../scripts/trace_statics.py"


rule draw_statics:
    input:
        statics=[f"results/statics{which}.nc" for which in made.statics],
    output:
        pdf=[f"results/figures/statics{which}.pdf" for which in made.statics],
        png=[
            report(
                f"results/figures/statics{which}.png",
                caption="../report/statics.rst",
                category="7 Device",
                labels={"figure": f"force and energy of the beam{which}"},
            )
            for which in made.statics
        ],
    log:
        "results/logs/draw_statics.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_statics"),
    message:
        "Draw the beam's force and energy"
    script:
        "../scripts/draw_statics.py"
