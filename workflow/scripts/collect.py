"""Rule collect: join the slabs into one cube."""

from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write
from snapmap.sweeps.assemble import collect_slabs
from snapmap.sweeps.cube import summary


def collect(slab_paths, axes, config, cube_path):
    """Join slabs on the axes of the whole grid, write the cube and say what is in it."""
    cube = collect_slabs(slab_paths, axes, config)
    write(cube, cube_path)
    print(f"{cube_path}: {summary(cube)}")


if __name__ == "__main__":
    run_rule(collect, snakemake)
