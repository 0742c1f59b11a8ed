"""Rule trace_statics: push the beam slowly through."""

from snapmap.beam.statics import statics
from snapmap.device import device_from
from snapmap.io.job_log import run_rule
from snapmap.io.netcdf import write


def trace_statics(device, path):
    """Trace the static force over displacement and write it; device in internal units."""
    write(statics(device_from(device)), path)


if __name__ == "__main__":
    run_rule(trace_statics, snakemake)
