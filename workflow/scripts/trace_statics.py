"""Rule trace_statics: push the beam slowly through."""

from snapmap.device import device_from
from snapmap.journal import journal
from snapmap.netcdf import write
from snapmap.statics import force_displacement


def trace_statics(device, path):
    """Trace the static force over displacement and write it; device in internal units."""
    write(force_displacement(device_from(device)), path)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        trace_statics(device=snakemake.params.device, path=snakemake.output.statics)
