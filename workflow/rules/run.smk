# A job reads the config itself. Its params are what its output depends on, as plain values:
# Snakemake runs it again when they change.
in_search = study.inputs(*THRESHOLD_SETTINGS)
axes = {key: values.tolist() for key, values in study.axes.items()}
tolerances = study.tolerances._asdict() if study.tolerances else {}
required = [
    {key: value for key, value in one.items() if key != "shocks"}
    for one in study.requirements
]


rule simulate_slab:
    output:
        slab="results/slabs/{slab}.nc",
    log:
        "results/logs/simulate_slab_{slab}.log",
    priority: 100
    retries: 1
    threads: 1
    resources:
        mem_mb=lambda wildcards, attempt: attempt * requests[wildcards.slab].mem_mb,
        runtime=lambda wildcards, attempt: attempt * requests[wildcards.slab].runtime,
    params:
        code=numbers,
        axes=lambda wildcards: slabs[wildcards.slab],  # all else is in its name
    message:
        "Simulate the cells"
    script:
        "../scripts/jobs.py"


rule collect:
    input:
        slab=[f"results/slabs/{name}.nc" for name in slabs],
    output:
        cube="results/cube.nc",
    log:
        "results/logs/collect.log",
    priority: 90
    resources:
        mem_mb=memory(2000),
    params:
        code=numbers,
        axes=axes,
        inputs=study.document(),
    message:
        "Join the slabs to one cube"
    script:
        "../scripts/jobs.py"


rule find_threshold:
    output:
        threshold="results/threshold.nc",
        table="results/thresholds.csv",
        statics=[f"results/statics{which}.nc" for which in made.statics],
    log:
        "results/logs/find_threshold.log",
    # Beside the first cells, not after them: of these no two then compile the same kernel at once.
    priority: 110
    threads: half
    resources:
        mem_mb=memory(2000),
    params:
        code=numbers,
        inputs=in_search,
        axes=axes | {"N": axes["N"][-1]},
        tolerance=study.threshold_tolerance,
    message:
        "Find the thresholds"
    script:
        "../scripts/jobs.py"


rule trace_cells:
    input:
        cube="results/cube.nc",
    output:
        traces="results/traces.nc",
    log:
        "results/logs/trace_cells.log",
    priority: 65
    threads: half
    resources:
        mem_mb=memory(2000),
    params:
        code=numbers,
        inputs=study.inputs(),
    message:
        "Trace the motion of the cells"
    script:
        "../scripts/jobs.py"


rule check_requirements:
    output:
        requirements="results/requirements.csv",
    log:
        "results/logs/check_requirements.log",
    priority: 50
    # A few single shocks do not fill one.
    threads: 4 if study.vibrations or study.spectra else 1
    params:
        code=numbers,
        inputs=in_search,
        requirements=required + study.vibrations + study.spectra,
        axes={key: axes[key] for key in ("C", "temperature") if key in axes},
        tolerance=study.threshold_tolerance,
    message:
        "Check the required shocks"
    script:
        "../scripts/jobs.py"


rule find_window:
    output:
        window="results/window.nc",
    log:
        "results/logs/find_window.log",
    priority: 48
    threads: 4
    resources:
        mem_mb=memory(2000),
    params:
        code=numbers,
        inputs=in_search,
        axes={key: axes[key] for key in axes if key in (*VALUES, "C")},
        tolerances=tolerances,
        requirements=required,
    message:
        "Find the window of the requirements"
    script:
        "../scripts/jobs.py"


rule find_tolerance:
    output:
        tolerance="results/tolerance.nc",
    log:
        "results/logs/find_tolerance.log",
    priority: 45
    threads: 4
    resources:
        mem_mb=memory(4000),
    params:
        code=numbers,
        inputs=in_search,
        axes={key: axes[key] for key in ("C", "f0", "N", "temperature") if key in axes},
        tolerances=tolerances,
        requirements=required,
        left_out=[one["name"] for one in study.vibrations + study.spectra],
    message:
        "Find the thresholds of devices as made"
    script:
        "../scripts/jobs.py"


rule fit_calibration:
    output:
        calibration="results/calibration.nc",
    log:
        "results/logs/fit_calibration.log",
    priority: 45
    threads: 4
    params:
        code=numbers,
        inputs=in_search,
        # A function, as a path may have braces.
        calibration=lambda wildcards: study.calibration and study.calibration[1:],
    message:
        "Read values of the device off measured shots"
    script:
        "../scripts/jobs.py"


rule write_datasheet:
    input:
        **({"tolerance": "results/tolerance.nc"} if study.tolerances else {}),
        requirements="results/requirements.csv",
    output:
        datasheet="results/datasheet.md",
    log:
        "results/logs/write_datasheet.log",
    priority: 30
    params:
        code=numbers,
        inputs=in_search,
        title=study.title,
        requirements=required,
    message:
        "Write the data sheet"
    script:
        "../scripts/jobs.py"


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
        code=numbers,
        inputs=lambda wildcards: replace(
            study, device=made.histories[wildcards.cell].device
        ).inputs("horizon", "until", "energy_tolerance", "start"),
        shock=lambda wildcards: made.histories[wildcards.cell].shock,
    message:
        "Follow single cells in full"
    script:
        "../scripts/jobs.py"
