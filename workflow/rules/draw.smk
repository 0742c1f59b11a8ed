plots = {
    key: views(getattr(made, key))
    for key in ("snaps", "times", "ends", "together", "fields")
}
plots |= {"curves": views(study.curves), "boundary": views(study.boundary)}
of_cells = {"cube": "results/cube.nc", "threshold": "results/threshold.nc"}
traced = {"traces": path for path in made.traces}
of_stress = of_cells | (traced if study.has_strength else {})
every_study_has = of_cells | {
    "statics": [f"results/statics{which}.nc" for which in made.statics],
    "history": [f"results/histories/{cell}.nc" for cell in made.histories],
}
window = {key: study.units[key] for key in made.window}
of_batch = {"places": made.batches, "yields": made.yields}
# By their caption: the part of the report, and figures.
FIGURES_OF = {
    "snap_maps": ("1 Which shock snaps it", made.snap_stems),
    "thresholds": ("2 Thresholds", made.curve_stems),
    "maps": ("3 When it snaps, where it ends", made.map_stems),
    "page": ("4 Page", ["explore"]),
    "requirements": ("5 Requirements", ["requirements"]),
    "window": ("5 Requirements", ["window"]),
    "tolerance": ("6 Devices as made", made.batch_stems),
    "calibration": ("6 Devices as made", ["calibration"]),
    "statics": ("7 Device", [f"statics{which}" for which in made.statics]),
    "histories": ("8 Histories", [f"history_{cell}" for cell in made.histories]),
}
OF_STUDY = ["thresholds", "maps", "statics", "histories"]
seen = {"views": plots, "own_points": own_points}
# By the rule's name without draw_, the most urgent first: captions, files and values.
DRAWN = {
    "snaps": (["snap_maps"], of_stress, seen),
    "study": (OF_STUDY, every_study_has, seen),
    "page": ([], of_cells | traced, {"horizon": study.settings.horizon}),
    "requirements": ([], {"requirements": "results/requirements.csv"}, {}),
    "window": ([], {"window": "results/window.nc"}, {"axes": window}),
    "tolerance": ([], {"tolerance": "results/tolerance.nc"}, of_batch),
    "calibration": ([], {"calibration": "results/calibration.nc"}, {}),
}


def figures(caption):
    part, stems = FIGURES_OF[caption]
    for stem in stems:
        paths = [f"results/figures/{stem}.{ending}" for ending in ("png", "pdf")]
        shown, *others = ["results/explore.html"] if caption == "page" else paths
        labels = {"figure": stem}
        yield report(shown, f"../report/{caption}.rst", category=part, labels=labels)
        yield from others


for place, (what, (captions, files, values)) in enumerate(DRAWN.items()):

    rule:
        name:
            f"draw_{what}"
        input:
            **files,
        output:
            [path for caption in captions or [what] for path in figures(caption)],
        log:
            f"results/logs/draw_{what}.log",
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
