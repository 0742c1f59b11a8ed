"""The applications: each folder of FOLDERS holds all that is its own, and its line attaches it.

The core imports none of them.  An application may import the core, `config`, `figures`, and the
applications that its first docstring line names after "Imports:".  The `__init__.py` of its folder
is its contract, a module of which every name may be missing:

    public          functions for Python by name, each with the module of the folder that has it
    section()       the field of its key in a config
    key             that key, if it is not the name of the folder
    described()     sections by their headings on docs/config.md
    request(section, study, document)   what a study asks of it; ValueError, one line
    files(study)    SHA-256 of the files that its section names, by path
    doubts(study)   lines on what is hardly meant
    marks(study)    shocks that maps of cells show: name, f0 (Hz), N, and how each may push
    alone(study)    f0 (Hz) of cells that it follows beside the grid
    outputs(study)  files that it makes, by name; none where nothing is asked
    inputs(study)   results that it reads, by name
    params(study)   plain values on which its product depends, beside device, pulse and model
    rule, message   of its job; threads, megabytes, priority: what the job may have
    run(study, ...) makes the product; takes NAME_path of its inputs and outputs, as rules do
    observe(model, cells, observed, settings)   floats that it adds to the cells of a cube, by name
    observing(model, cells, settings)   core time of that, s, for each cell
    in_history(model, cells, settings)  attributes that it adds to a cell followed in full
    in_statics(device, first, displacement, force)  attributes that it adds to statics; first:
                    w(L/2) at rest, um
    in_datasheet(study, rows)   tables that it adds to a data sheet, of the worst verdicts
    cost(study)     core time of the job, s, where that is worth telling
    quick           whether it is made beside the thresholds, and drawn with them: a job's start
                    takes longer
    figures(study)  arguments of `draw` by the stem of a figure
    drawn_from(study)   files that `draw` reads, by name; by default its outputs
    draw(figures, folder, ...)   draws them; takes NAME_path of these files
    part            heading of its figures in the report; their caption is caption.rst

A key, a product, a figure or a public function of an application is gone once its line is gone.
"""

from collections.abc import Callable
from importlib import import_module
from types import ModuleType

FOLDERS = (
    "statics",
    "histories",
    "requirements",
    "spectra",
    "electrode",
    "window",
    "tolerances",
    "calibration",
    "design",
    "datasheet",
    "boundary",
    "laws",
    "stress",
    "page",
)


def attached() -> dict[str, ModuleType]:
    """The applications by the names of their folders."""
    return {folder: import_module(f"{__name__}.{folder}") for folder in FOLDERS}


def key_of(folder: str, application: ModuleType) -> str:
    """The key of an application in a config."""
    return getattr(application, "key", folder)


def gather(part: str, *arguments: object) -> dict[str, object]:
    """Collect what each application that has a part gives for it, by its folder, if anything."""
    having = {folder: module for folder, module in attached().items() if hasattr(module, part)}
    parts = {folder: getattr(module, part)(*arguments) for folder, module in having.items()}
    return {folder: value for folder, value in parts.items() if value}


def functions(part: str) -> list[Callable]:
    """A part of each application that has it."""
    return [getattr(module, part) for module in attached().values() if hasattr(module, part)]


def merge(part: str, *arguments: object) -> dict:
    """Collect in one mapping what each application that has a part gives for it."""
    return {k: v for give in functions(part) for k, v in give(*arguments).items()}


def public_names() -> dict[str, str]:
    """Modules by the names of the public functions that they have."""
    return {
        name: f"applications.{folder}.{module}"
        for folder, application in attached().items()
        for name, module in getattr(application, "public", {}).items()
    }
