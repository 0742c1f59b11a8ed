PARTS = {
    "snap_maps": "1 Which shock snaps it",
    "thresholds": "2 Thresholds",
    "maps": "3 When it snaps, where it ends",
}


rule draw_study:
    input:
        **making.get("stress", {}),
        cube="results/cube.nc",
        threshold="results/threshold.nc",
        others=made_quickly,
    output:
        [path for caption in PARTS for path in figures(caption)],
        [path for name in drawn_together for path in figures_of(name)],
    log:
        "results/logs/draw_study.log",
    priority: 85
    group:
        "figures"
    threads: cores
    resources:
        runtime=10,
        mem_mb=memory(2000),
    params:
        views=constant(views._asdict()),
        applications=constant(
            {
                name: (drawing_of[name], part.saved_in, part.drawn_from(study))
                for name, part in attached().items()
                if name in drawn_together
            }
        ),
        code=drawing,
    message:
        "Draw the study"
    script:
        "../scripts/draw.py"
