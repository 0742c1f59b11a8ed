"""The applications: each line of FOLDERS attaches the folder that holds all of one application.

The core imports none of them.  An application may import the core, `config`, `figures`, and the
applications that its first docstring line names after "Imports:".  The `__init__.py` of its folder
is its contract, in which every name is optional:

    public          functions for Python by name, each with the module of the folder that has it
    section()       the field of its key in a config
    key             that key, if it is not the name of the folder
    described()     sections by their headings on docs/config.md
    request(section, study, document)   its section as `study.requests` holds it; ValueError, one
                    line, for what the study cannot have
    files(study)    SHA-256 of the files that its section names, by path
    refuse(study)   raises ValueError, one line, for what a few runs show that its job cannot make;
                    called once, before the first job
    doubts(study)   lines about values that are probably mistakes
    marks(study)    shocks that maps of cells show: name, f0 (Hz), N, and a list of pulse,
                    direction and start under which the shock counts
    alone(study)    f0 (Hz) of the single cells that it simulates beside the grid
    outputs(study)  files that it makes, by name; empty if the study requests none
    inputs(study)   results that it reads, by name
    params(study)   plain values on which its product depends, beside device, pulse and model
    rule, message   name and message of its job; threads, megabytes, priority: its resources
    run(study, ...) makes the product; takes NAME_path of its inputs and outputs, as rules do
    observe(model, cells, observed, settings)   floats that it adds to the cells of a cube, by name
    observing(model, cells, settings)   core time that `observe` takes for each cell, s
    in_history(model, cells, settings)  numbers that it adds to the history of a cell
    in_statics(device, first, displacement, force)  numbers that it adds to statics; first:
                    w(L/2) at rest, um
    in_datasheet(study, rows)   tables that it adds to a data sheet; rows: verdicts, worst first
    cost(study)     core time of its job, s, if `check` should tell it
    quick           true if the job of the thresholds makes and draws its product as well, as a
                    job of its own would take longer to start than to run
    figures(study)  arguments of `draw` by the name of a figure; empty if there is none to draw
    saved_in, endings   folder of these figures, and the endings of the files that each of them is;
                    by default results/figures, png and pdf
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
    """Import the applications; returns their modules by the names of their folders."""
    return {folder: import_module(f"{__name__}.{folder}") for folder in FOLDERS}


def key_of(folder: str, application: ModuleType) -> str:
    """The key of an application in a config."""
    return getattr(application, "key", folder)


def gather(part: str, *arguments: object) -> dict[str, object]:
    """Call a part of each application that has it; returns what is not empty, by folder."""
    having = {folder: module for folder, module in attached().items() if hasattr(module, part)}
    parts = {folder: getattr(module, part)(*arguments) for folder, module in having.items()}
    return {folder: value for folder, value in parts.items() if value}


def functions(part: str) -> list[Callable]:
    """Return a part of each application that has it."""
    return [getattr(module, part) for module in attached().values() if hasattr(module, part)]


def refuse_all(study: object) -> None:
    """Refuse a study before its first job; a ValueError, one line, names the key."""
    for folder, module in attached().items():
        if hasattr(module, "refuse"):
            try:
                module.refuse(study)
            except ValueError as error:
                raise ValueError(f"{key_of(folder, module)}: {error}") from None


def merge(part: str, *arguments: object) -> dict:
    """Call a part of each application that has it; returns the union of the mappings."""
    return {k: v for give in functions(part) for k, v in give(*arguments).items()}


def public_names() -> dict[str, str]:
    """Return the module of each public function, by the function's name."""
    return {
        name: f"applications.{folder}.{module}"
        for folder, application in attached().items()
        for name, module in getattr(application, "public", {}).items()
    }
