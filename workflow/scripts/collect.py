"""Rule collect: join the slabs into one cube."""

from snapmap.cube import collect_slabs, summary, write


def collect(slab_paths, names, config, cube_path):
    """Join slabs, whose nested names give their places, write the cube and say what is in it."""
    cube = collect_slabs(slab_paths, names, config)
    write(cube, cube_path)
    print(f"{cube_path}: {summary(cube)}")


if __name__ == "__main__":
    collect(
        slab_paths=snakemake.input.slabs,
        names=snakemake.params.names,
        config=snakemake.params.config,
        cube_path=snakemake.output.cube,
    )
