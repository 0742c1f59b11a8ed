views_of = {key: views(getattr(made, key)) for key in made._fields}
of_cells = {"cube": "results/cube.nc", "threshold": "results/threshold.nc"}
of_stress = of_cells | making.get("stress", {})
drawn_quickly = [name for name in drawing_of if is_quick[name]]
PARTS = {
    "snap_maps": "1 Which shock snaps it",
    "thresholds": "2 Thresholds",
    "maps": "3 When it snaps, where it ends",
}


rule draw_snaps:
    input:
        **of_stress,
    output:
        list(figures("snap_maps")),
    log:
        "results/logs/draw_snaps.log",
    priority: 85
    group:
        "figures"
    resources:
        runtime=10,
    params:
        views=views_of,
        own_points=own_points,
        code=drawing,
    message:
        "Draw the snaps"
    script:
        "../scripts/draw.py"


rule draw_study:
    input:
        **of_cells,
        others=made_quickly,
    output:
        list(figures("thresholds")) + list(figures("maps")),
        [path for name in drawn_quickly for path in figures_of(name)],
    log:
        "results/logs/draw_study.log",
    priority: 84
    group:
        "figures"
    resources:
        runtime=10,
    params:
        views=views_of,
        own_points=own_points,
        quick={name: (drawing_of[name], paths_of(name)) for name in drawn_quickly},
        code=drawing,
    message:
        "Draw the study"
    script:
        "../scripts/draw.py"


results += [path for caption in PARTS for path in map(str, figures(caption))]
