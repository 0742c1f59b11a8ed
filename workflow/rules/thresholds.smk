rule find_threshold:
    output:
        threshold="results/threshold.nc",
    log:
        "results/logs/find_threshold.log",
    conda:
        "../envs/snapmap.yaml"
    threads: 4
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
    params:
        code=code("find_threshold"),
        device=asdict(study.device),
        model=study.model,
        axes={"C": study.C.tolist(), "f0": study.f0.tolist()},
        highest=float(study.N[-1]),
        followed={
            "horizon": study.protocol.horizon,
            "energy_tolerance": study.protocol.energy_tolerance,
        },
        tolerance=study.threshold_tolerance,
    message:
        "Find the thresholds"
    script:
        "../scripts/find_threshold.py"


rule draw_thresholds:
    input:
        threshold="results/threshold.nc",
    output:
        pdf="results/figures/thresholds.pdf",
        png=report(
            "results/figures/thresholds.png",
            caption="../report/thresholds.rst",
            category="Thresholds",
            labels={"figure": "over the pulse's frequency"},
        ),
    log:
        "results/logs/draw_thresholds.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_thresholds"),
    message:
        "Draw the thresholds"
    script:
        "../scripts/draw_thresholds.py"


rule draw_damage_boundary:
    input:
        threshold="results/threshold.nc",
    output:
        pdf="results/figures/damage_boundary.pdf",
        png=report(
            "results/figures/damage_boundary.png",
            caption="../report/damage_boundary.rst",
            category="Thresholds",
            labels={"figure": "damage boundary"},
        ),
    log:
        "results/logs/draw_damage_boundary.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_damage_boundary"),
    message:
        "Draw the damage boundary"
    script:
        "../scripts/draw_damage_boundary.py"
