rule draw_snap_maps:
    input:
        **({"traces": "results/traces.nc"} if study.has_strength else {}),
        cube="results/cube.nc",
        threshold="results/threshold.nc",
    output:
        pdf=[f"results/figures/{stem}.pdf" for stem in made.snap_stems],
        png=[
            report(
                f"results/figures/{stem}.png",
                caption="../report/snap_maps.rst",
                category="1 Which shock snaps it",
                labels={"figure": stem},
            )
            for stem in made.snap_stems
        ],
    log:
        "results/logs/draw_snap_maps.log",
    priority: 85
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_snap_maps"),
        views=[view._asdict() for view in made.snaps],
        together=[view._asdict() for view in made.together],
        fields=[view._asdict() for view in made.fields],
        own_points=own_points,
    message:
        "Draw which cells snap, with the thresholds"
    script:
        "../scripts/draw_snap_maps.py"


rule draw_maps:
    input:
        cube="results/cube.nc",
    output:
        pdf=[f"results/figures/{stem}.pdf" for stem in made.map_stems],
        png=[
            report(
                f"results/figures/{stem}.png",
                caption="../report/maps.rst",
                category="3 When it snaps, where it ends",
                labels={"figure": stem},
            )
            for stem in made.map_stems
        ],
    log:
        "results/logs/draw_maps.log",
    priority: 80
    group:
        "figures"
    resources:
        runtime=10,
    params:
        code=code("draw_maps"),
        times=[view._asdict() for view in made.times],
        ends=[view._asdict() for view in made.ends],
        together=[view._asdict() for view in made.together if made.ends],
        own_points=own_points,
    message:
        "Draw when the beams snap, and where they end"
    script:
        "../scripts/draw_maps.py"
