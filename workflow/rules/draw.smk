plots = {
    key: views(getattr(made, key))
    for key in ("snaps", "times", "ends", "together", "fields")
}
plots |= {"curves": views(study.curves), "boundary": views([study.boundary])}
every_study_has = {
    "cube": "results/cube.nc",
    "threshold": "results/threshold.nc",
    "statics": [f"results/statics{which}.nc" for which in made.statics],
    "history": [f"results/histories/{cell}.nc" for cell in made.histories],
}
if study.has_strength:
    every_study_has["traces"] = "results/traces.nc"
of_batch = {"places": made.batches, "yields": made.yields}
of_settled = {"beam_dampings": [0.0, 4e-4], "C": 25.0}
# By their caption: the part of the report, and figures.
FIGURES_OF = {
    "snap_maps": ("1 Which shock snaps it", made.snap_stems),
    "thresholds": ("2 Thresholds", made.curve_stems),
    "maps": ("3 When it snaps, where it ends", made.map_stems),
    "requirements": ("5 Requirements", ["requirements"]),
    "tolerance": ("6 Devices as made", made.batch_stems),
    "calibration": ("6 Devices as made", ["calibration"]),
    "statics": ("7 Device", [f"statics{which}" for which in made.statics]),
    "histories": ("8 Histories", [f"history_{cell}" for cell in made.histories]),
    "accuracy": ("9 Accuracy and stability", ["accuracy{size}"]),
    "convergence": ("9 Accuracy and stability", ["convergence"]),
    "stability": ("9 Accuracy and stability", ["stability"]),
    "settled": ("9 Accuracy and stability", ["settled"]),
}
OF_STUDY = ["snap_maps", "thresholds", "maps", "statics", "histories"]
# By the rule's name without draw_, the most urgent first: captions, files and values.
DRAWN = {
    "study": (OF_STUDY, every_study_has, {"views": plots, "own_points": own_points}),
    "requirements": ([], {"requirements": "results/requirements.csv"}, {}),
    "tolerance": ([], {"tolerance": "results/tolerance.nc"}, of_batch),
    "calibration": ([], {"calibration": "results/calibration.nc"}, {}),
    "accuracy": ([], {"accuracy": "results/accuracy{size}.nc"}, {}),
    "convergence": ([], {"accuracy": "results/accuracy.nc"}, {}),
    "stability": ([], {"stability": "results/stability.nc"}, {}),
    "settled": ([], {"settled": "results/settled.nc"}, of_settled),
}


def figures(caption):
    part, stems = FIGURES_OF[caption]
    for stem in stems:
        png, labels = f"results/figures/{stem}.png", {"figure": stem}
        yield report(png, f"../report/{caption}.rst", category=part, labels=labels)
        yield f"results/figures/{stem}.pdf"


for place, (what, (captions, files, values)) in enumerate(DRAWN.items()):

    rule:
        name:
            f"draw_{what}"
        input:
            **files,
        output:
            [path for caption in captions or [what] for path in figures(caption)],
        log:
            f"results/logs/draw_{what}{'{size}' * (what == 'accuracy')}.log",
        priority: 85 - place
        group:
            "figures"
        resources:
            runtime=10,
        params:
            **values,
            code=drawing,
        message:
            f"Draw the {what}"
        script:
            "../scripts/draw.py"


rule write_page:
    input:
        cube="results/cube.nc",
        traces="results/traces.nc",
        threshold="results/threshold.nc",
    output:
        page=report(
            "results/explore.html",
            caption="../report/page.rst",
            category="4 Page",
            labels={"page": "explore"},
        ),
    log:
        "results/logs/write_page.log",
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=drawing,
        horizon=study.settings.horizon,
    message:
        "Write the page"
    script:
        "../scripts/draw.py"
