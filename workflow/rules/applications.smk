# A job reads the config itself. Its params are plain values on which its output depends: Snakemake
# runs the job again when they change.
in_search = study.inputs(*THRESHOLD_SETTINGS)
axes = {key: values.tolist() for key, values in study.axes.items()}
making = gather("outputs", study)
figures_by_name = {
    name: application.figures(study)
    for name, application in attached().items()
    if hasattr(application, "figures")
    and (name in making or hasattr(application, "drawn_from"))
}
drawing_of = {name: made for name, made in figures_by_name.items() if made}
is_quick = {name: hasattr(part, "quick") for name, part in attached().items()}
quick = {name: files for name, files in making.items() if is_quick[name]}
slow = [name for name in making if not is_quick[name]]
made_quickly = [
    path for files in quick.values() for paths in files.values() for path in paths
]


for name in slow:
    application = attached()[name]
    threads_of = getattr(application, "threads", 1)

    rule:
        name:
            application.rule
        input:
            **getattr(application, "inputs", lambda study: {})(study),
        output:
            **kept(making[name]),
        log:
            f"results/logs/{application.rule}.log",
        priority: getattr(application, "priority", 45)
        threads: threads_of(cores) if callable(threads_of) else threads_of
        resources:
            mem_mb=memory(getattr(application, "megabytes", 1000)),
        params:
            code=numbers,
            inputs=in_search,
            request=constant(application.params(study)),
        message:
            application.message
        script:
            "../scripts/jobs.py"


drawn_together = [name for name in drawing_of if is_drawn_with_the_study(name)]


for place, name in enumerate(name for name in drawing_of if name not in drawn_together):

    rule:
        name:
            f"draw_{name}"
        input:
            **drawn_from(name),
        output:
            figures_of(name),
        log:
            f"results/logs/draw_{name}.log",
        priority: 83 - place
        group:
            "figures"
        resources:
            runtime=10,
        params:
            figures=constant(drawing_of[name]),
            code=drawing,
        message:
            f"Draw the {name}"
        script:
            "../scripts/draw.py"


results = ["results/cube.nc"]
results += [path for name in drawing_of for path in map(str, figures_of(name))]
for files in making.values():
    for paths in files.values():
        results += [paths] if isinstance(paths, str) else paths
SUMMARIZED += [attached()[name].rule for name in slow]
