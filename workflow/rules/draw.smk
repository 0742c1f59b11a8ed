traced = {"traces": "results/traces.nc"} if study.has_strength else {}
threshold = {"threshold": "results/threshold.nc"}
cube = {"cube": "results/cube.nc"}
snaps = dict(
    views=views(made.snaps),
    together=views(made.together),
    fields=views(made.fields),
    own_points=own_points,
)
times_and_ends = dict(
    times=views(made.times),
    ends=views(made.ends),
    together=views(made.together if made.ends else []),
    own_points=own_points,
)
lines = dict(views=views(study.curves), boundary=study.boundary._asdict())
histories = [f"results/histories/{cell}.nc" for cell in made.histories]
history_stems = [f"history_{cell}" for cell in made.histories]
pushed = [f"results/statics{which}.nc" for which in made.statics]
static_stems = [f"statics{which}" for which in made.statics]
requirements = {"requirements": "results/requirements.csv"}
calibrated = {"calibration": "results/calibration.nc"}
of_batch = dict(places=made.batches, yields=made.yields)
PARTS = [
    "1 Which shock snaps it",
    "2 Thresholds",
    "3 When it snaps, where it ends",
    "4 Page",
    "5 Requirements",
    "6 Devices as made",
    "7 Device",
    "8 Histories",
    "9 Accuracy and stability",
]
# By the rule's name without draw_, which is that of its caption, the most urgent first: the part of
# the report, files, figures and values.
DRAWN = {
    "snap_maps": (1, threshold | cube | traced, made.snap_stems, snaps),
    "thresholds": (2, threshold, made.curve_stems, lines),
    "maps": (3, cube, made.map_stems, times_and_ends),
    "requirements": (5, requirements, ["requirements"], {}),
    "tolerance": (6, {"tolerance": "results/tolerance.nc"}, made.batch_stems, of_batch),
    "calibration": (6, calibrated, ["calibration"], {}),
    "statics": (7, {"statics": pushed}, static_stems, {}),
    "histories": (8, {"history": histories}, history_stems, {}),
    "accuracy": (9, {"accuracy": "results/accuracy{size}.nc"}, ["accuracy{size}"], {}),
    "convergence": (9, {"accuracy": "results/accuracy.nc"}, ["convergence"], {}),
    "stability": (9, {"stability": "results/stability.nc"}, ["stability"], {}),
    "settled": (
        9,
        {"settled": "results/settled.nc"},
        ["settled"],
        {"beam_dampings": [0.0, 4e-4], "C": 25.0},
    ),
}

for place, (what, (part, files, stems, values)) in enumerate(DRAWN.items()):

    rule:
        name:
            f"draw_{what}"
        input:
            **files,
        output:
            pdf=[f"results/figures/{stem}.pdf" for stem in stems],
            png=[
                report(
                    f"results/figures/{stem}.png",
                    caption=f"../report/{what}.rst",
                    category=PARTS[part - 1],
                    labels={"figure": stem},
                )
                for stem in stems
            ],
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
            f"Draw the {what.replace('_', ' ')}"
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
            category=PARTS[3],
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
