rule draw_maps:
    input:
        cube="results/cube.nc",
        threshold="results/threshold.nc",
    output:
        pdf=[f"results/figures/{stem}.pdf" for stem in map_stems],
        png=[
            report(
                f"results/figures/{stem}.png",
                caption="../report/maps.rst",
                category="Maps",
                labels={"figure": stem},
            )
            for stem in map_stems
        ],
    log:
        "results/logs/draw_maps.log",
    priority: 70
    conda:
        "../envs/snapmap.yaml"
    params:
        code=code("draw_maps"),
        views=[view._asdict() for view in study.maps],
        together=[view._asdict() for view in together],
        marks=[(asked.name, asked.f0, asked.N) for asked in study.requirements],
    message:
        "Draw the maps"
    script:
        "../scripts/draw_maps.py"
