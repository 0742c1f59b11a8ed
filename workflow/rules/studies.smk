nominal_device = device_sections(nominal(study.device))


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
        code=studied,
        device=nominal_device,
        pulse=study.pulse,
        axes=[axes[key] for key in ("C", "f0", "N")],
        settings=study.settings.asked(),
        plan=lambda wildcards: "quick" if wildcards.size else "full",
    message:
        "Measure error and time of every model: {output.accuracy}"
    script:
        "../scripts/jobs.py"


rule write_accuracy_table:
    input:
        accuracy="results/accuracy.nc",
    output:
        table="results/accuracy.md",
    log:
        "results/logs/write_accuracy_table.log",
    params:
        code=studied,
    message:
        "Write the tables of docs/accuracy.md"
    script:
        "../scripts/jobs.py"


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
        code=studied,
        device=nominal_device,
    message:
        "Follow the hard cases"
    script:
        "../scripts/jobs.py"


rule measure_settled:
    output:
        settled="results/settled.nc",
    log:
        "results/logs/measure_settled.log",
    threads: 1000
    params:
        code=studied,
        device=nominal_device,
        beam_dampings=[0.0, 4e-4, 4e-3],
    message:
        "Sweep with less and more damping"
    script:
        "../scripts/jobs.py"


rule write_stability_table:
    input:
        stability="results/stability.nc",
        settled="results/settled.nc",
    output:
        table="results/stability.md",
    log:
        "results/logs/write_stability_table.log",
    params:
        code=studied,
    message:
        "Write the tables of docs/stability.md"
    script:
        "../scripts/jobs.py"
