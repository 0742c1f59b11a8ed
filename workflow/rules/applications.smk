# What applications make, if the study asks for it: the folder of each, its job, what this reads and
# makes in results/. The rules take their values from the `__init__.py` of the folder.
#
# statics       find_threshold      -                                        statics.nc
# histories     simulate_histories  -                                        histories/*.nc
# requirements  check_requirements  -                                        requirements.csv
# window        find_window         -                                        window.nc
# tolerances    find_tolerance      -                                        tolerance.nc
# calibration   fit_calibration     -                                        calibration.nc
# datasheet     write_datasheet     requirements.csv, tolerance.nc           datasheet.md
# laws          find_laws           threshold.nc                             laws.nc
# stress        find_stress         cube.nc                                  stress.nc
# statics       draw_study          statics.nc                               figures/statics.*
# boundary      draw_study          threshold.nc                             figures/damage_boundary*
# histories     draw_histories      histories/*.nc                           figures/history_*
# requirements  draw_requirements   requirements.csv                         figures/requirements.*
# window        draw_window         window.nc                                figures/window.*
# tolerances    draw_tolerances     tolerance.nc                             figures/probability*
# tolerances    draw_tolerances     tolerance.nc                             figures/sensitivity*
# tolerances    draw_tolerances     tolerance.nc                             figures/yield*
# calibration   draw_calibration    calibration.nc                           figures/calibration.*
# laws          draw_laws           laws.nc                                  figures/laws.*
# page          draw_page           cube.nc, threshold.nc, requirements.csv  explore.html

# A job reads the config itself. Its params are plain values on which its output depends: Snakemake
# runs the job again when they change.
in_search = study.inputs(*OF_THRESHOLDS)
axes = {key: values.tolist() for key, values in study.axes.items()}
making = gather(lambda part: part.outputs(study))
drawing_of = gather(lambda part: part.drawn(study))
quick = {name: files for name, files in making.items() if attached()[name].quick}
slow = [name for name in making if name not in quick]
made_quickly = [path for files in quick.values() for path in listed(files)]


for name in slow:
    application = attached()[name]

    rule:
        name:
            application.rule
        input:
            **application.inputs(study),
        output:
            **kept(making[name]),
        log:
            f"results/logs/{application.rule}.log",
        priority: application.priority
        threads: application.threads or half
        resources:
            mem_mb=memory(application.megabytes),
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
            **attached()[name].drawn_from(study),
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
results += [path for files in making.values() for path in listed(files)]
SUMMARIZED += [attached()[name].rule for name in slow]
