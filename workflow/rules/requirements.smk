rule check_requirements:
    output:
        requirements="results/requirements.csv",
    log:
        "results/logs/check_requirements.log",
    priority: 50
    # A few single shocks do not fill one.
    threads: 4 if study.vibrations or study.spectra else 1
    params:
        code=code("check_requirements"),
        study=study.values(*THRESHOLD_SETTINGS),
        requirements=[asked._asdict() for asked in study.requirements],
        vibrations=[asked._asdict() for asked in study.vibrations],
        spectra=[asked._asdict() for asked in study.spectra],
        C=study.axes["C"].tolist(),
        tolerance=study.threshold_tolerance,
    message:
        "Check the required shocks"
    script:
        "../scripts/check_requirements.py"


rule draw_requirements:
    input:
        requirements="results/requirements.csv",
    output:
        pdf="results/figures/requirements.pdf",
        png=report(
            "results/figures/requirements.png",
            caption="../report/requirements.rst",
            category="5 Requirements",
            labels={"figure": "margins"},
        ),
    log:
        "results/logs/draw_requirements.log",
    priority: 40
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_requirements"),
    message:
        "Draw the margins of the required shocks"
    script:
        "../scripts/draw_requirements.py"


rule write_datasheet:
    input:
        requirements="results/requirements.csv",
    output:
        datasheet="results/datasheet.md",
    log:
        "results/logs/write_datasheet.log",
    priority: 30
    threads: 4
    params:
        code=code("write_datasheet"),
        study=study.values(*THRESHOLD_SETTINGS),
        C=study.axes["C"].tolist(),
        tolerances=study.tolerances._asdict() if study.tolerances else {},
        requirements=[asked._asdict() for asked in study.requirements],
    message:
        "Write the data sheet"
    script:
        "../scripts/write_datasheet.py"
