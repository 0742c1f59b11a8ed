rule write_crate:
    input:
        result=finished,
    output:
        crate="results/crate.zip",
    log:
        "results/logs/write_crate.log",
    params:
        code=code("write_crate"),
        config=lambda wildcards: config,
        named=lambda wildcards: sorted(study.files()),
    message:
        "Pack the study"
    script:
        "../scripts/write_crate.py"
