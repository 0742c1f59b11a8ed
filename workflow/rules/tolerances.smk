rule find_tolerance:
    output:
        tolerance="results/tolerance.nc",
    log:
        "results/logs/find_tolerance.log",
    priority: 45
    threads: 4
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 4000,
    params:
        code=code("find_tolerance"),
        study=study.values(*THRESHOLD_SETTINGS),
        axes={key: study.axes[key].tolist() for key in ("C", "f0", "N")},
        tolerances=study.tolerances._asdict() if study.tolerances else {},
        requirements=[asked._asdict() for asked in study.requirements],
        left_out=[asked.name for asked in (*study.vibrations, *study.spectra)],
    message:
        "Find the thresholds of devices as made"
    script:
        "../scripts/find_tolerance.py"


rule draw_tolerance:
    input:
        tolerance="results/tolerance.nc",
    output:
        pdf=[f"results/figures/{stem}.pdf" for stem in made.batch_stems],
        png=[
            report(
                f"results/figures/{stem}.png",
                caption="../report/tolerances.rst",
                category="6 Devices as made",
                labels={"figure": stem},
            )
            for stem in made.batch_stems
        ],
    log:
        "results/logs/draw_tolerance.log",
    priority: 40
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_tolerance"),
        places=made.batches,
        yields=made.yields,
    message:
        "Draw what devices as made do"
    script:
        "../scripts/draw_tolerance.py"
