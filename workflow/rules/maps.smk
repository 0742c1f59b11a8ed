rule draw_map:
    input:
        cube="results/cube.nc",
        threshold="results/threshold.nc",
    output:
        pdf="results/figures/map_C{damping}.pdf",
        png=report(
            "results/figures/map_C{damping}.png",
            caption="../report/map.rst",
            category="Maps",
            labels={"figure": "C = {damping} uN us/um"},
        ),
    log:
        "results/logs/draw_map_{damping}.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_map"),
        damping_index=lambda wildcards: dampings.index(wildcards.damping),
    message:
        "Draw the map for C = {wildcards.damping} uN us/um"
    script:
        "../scripts/draw_map.py"


rule draw_maps:
    input:
        cube="results/cube.nc",
        threshold="results/threshold.nc",
    output:
        pdf="results/figures/maps.pdf",
        png=report(
            "results/figures/maps.png",
            caption="../report/maps.rst",
            category="Maps",
            labels={"figure": "all C"},
        ),
    log:
        "results/logs/draw_maps.log",
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_maps"),
    message:
        "Draw the maps of all C side by side"
    script:
        "../scripts/draw_maps.py"
