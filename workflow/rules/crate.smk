def finished(wildcards):
    """All that a run leaves; a function, as `all` is read last."""
    stems = ["threshold", "traces", *(f"statics{which}" for which in made.statics)]
    stems += ["tolerance"] * bool(study.tolerances)
    stems += ["calibration"] * bool(study.calibration)
    stems += [f"histories/{name}" for name in made.histories]
    data = [f"results/{stem}.nc" for stem in stems]
    return [*rules.all.input, "results/thresholds.csv", *data]


rule write_crate:
    input:
        result=finished,
    output:
        crate="results/crate.zip",
    log:
        "results/logs/write_crate.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("write_crate"),
        config=lambda wildcards: config,
        named=lambda wildcards: sorted(study.files()),
    message:
        "Pack the study"
    script:
        "../scripts/write_crate.py"
