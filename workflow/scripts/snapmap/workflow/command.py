"""The command `snapmap`: it writes a first config, checks a config, and runs it."""

import os
import shutil
import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile

from .. import __version__
from ..files.extras import needing
from ..files.named import naming

PACKAGE = Path(__file__).parents[1]
PIPELINE = next(path for path in (PACKAGE / "pipeline", PACKAGE.parents[2]) if path.is_dir())
"""The folder of the Snakefile: within the package in a wheel, else the checkout."""
CONFIG, SCHEMA = "config.yaml", "schema.json"
OTHERS = (
    "All other options and targets are those of Snakemake: -n tells the jobs, and how many cells"
    " are new; results/cube.nc makes that file alone; --directory FOLDER runs in another folder."
)
"""What `snapmap run --help` ends with."""


def main(words: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status. words: arguments, by default of the process."""
    parser = ArgumentParser("snapmap", description="Snap maps of a bistable beam under shock.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    verbs = parser.add_subparsers(required=True)
    for do, what in (
        (init, "write a first config, with comments"),
        (check, "report errors, warnings and cost of a config"),
        (run, "compute the results of a config, in results/ of the current folder"),
    ):
        verb = verbs.add_parser(do.__name__, help=what, description=f"{what.capitalize()}.")
        verb.set_defaults(do=do)
        if do is init:
            verb.add_argument("folder", nargs="?", default=".", type=Path, help="of the config")
        else:
            verb.add_argument("config", type=Path, help="YAML file of a study; init writes one")
    verb.epilog = OTHERS
    verb.add_argument("--cores", help="number of cores; all by default, or as a --profile says")
    known, others = parser.parse_known_args(words)
    values = vars(known)
    if known.do is run:
        values["others"] = others  # Snakemake's: -n, targets
    elif others:
        parser.error(f"unrecognized arguments: {' '.join(others)}")
    try:
        values.pop("do")(**values)
    except (ImportError, OSError, ValueError) as fault:
        print(fault, file=sys.stderr)
        return 1
    return 0


def init(folder: Path) -> None:
    """Write the config of a sensor, with comments, and its schema; ValueError if there is one."""
    path = folder / CONFIG
    for source, new in (("sensor.yaml", path), (SCHEMA, folder / SCHEMA)):
        with naming(new):
            if new.exists() or new.is_symlink():
                raise ValueError("exists already; name another folder")
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(PIPELINE / "config" / source, new)
    print(f"{path}: write your device there, then: snapmap check {path}")


def check(config: Path) -> None:
    """Print the devices of a config, doubts and cost; raises ValueError, a line for each fault."""
    with needing("snapmap check"):
        from ..applications.whole import doubts, load_config
        from ..config.doubts import descriptions
        from ..config.yaml_file import read_document
    from ..solver.cost import spoken
    from .plan import amounts, core_seconds, make_plan

    study = load_config(read_document(config))
    plan = make_plan(study)
    for line in filter(None, [*descriptions(study), study.left_out, *doubts(study)]):
        print(line)
    cells, *others = amounts(study).items()
    sizes = ", ".join(f"{key} {values.size}" for key, values in study.axes.items())
    jobs = "a job" if len(plan.slabs) == 1 else f"{len(plan.slabs)} jobs"
    print(f"{cells[1]} cells ({sizes}) in {jobs} of one core")
    print("beside them: " + ", ".join(f"{what} {count}" for what, count in others if count))
    print(f"core time, about: {spoken(core_seconds(study, plan))}")


def run(config: Path, cores: str | None, others: Sequence[str] = ()) -> None:
    """Run the workflow in the current folder, and exit as Snakemake does; ValueError, one line.

    cores: their number; None is all, or what a profile of a cluster says
    others: options and targets of Snakemake, such as -n
    """
    with needing("snapmap run"):
        from snakemake.cli import main as snakemake

        from ..config.yaml_file import read_document
    read_document(config)  # Snakemake would evaluate the expressions of __use_yte__
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    with naming(f"{cache}, which XDG_CACHE_HOME can replace"):
        cache.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=cache).close()  # Snakemake writes there, or ends in a traceback
    profile = PIPELINE / "profiles" / "default" / "profile.yaml"  # else the study's own, with code
    options = "--configfile", config  # it takes all words up to the next option
    options += "--snakefile", PIPELINE / "Snakefile", "--workflow-profile", profile
    if cores or not any(word.startswith("--profile") for word in others):
        options += "--cores", cores or "all"
    snakemake([str(word) for word in (*options, *others)])


if __name__ == "__main__":
    sys.exit(main())
