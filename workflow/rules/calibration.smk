rule fit_calibration:
    output:
        calibration="results/calibration.nc",
    log:
        "results/logs/fit_calibration.log",
    priority: 45
    threads: 4
    params:
        code=code("fit_calibration"),
        study=study.values(*THRESHOLD_SETTINGS),
        calibration=calibration,
    message:
        "Read values of the device off measured shots"
    script:
        "../scripts/fit_calibration.py"


rule draw_calibration:
    input:
        calibration="results/calibration.nc",
    output:
        pdf="results/figures/calibration.pdf",
        png=report(
            "results/figures/calibration.png",
            caption="../report/calibration.rst",
            category="6 Measured shots",
            labels={"figure": "calibration"},
        ),
    log:
        "results/logs/draw_calibration.log",
    priority: 40
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_calibration"),
    message:
        "Draw measured shots over the fitted threshold"
    script:
        "../scripts/draw_calibration.py"
