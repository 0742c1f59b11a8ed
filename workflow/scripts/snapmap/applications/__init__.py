"""The applications: each line of FOLDERS attaches the folder that holds all of one application.

The core imports none of them.  An application may import the core, `config`, `figures`, and the
applications that the first line of its `__init__.py` names after "Imports:".  That file says what
it adds, in a subclass of `Application`, and has the one instance, `application`.  A key, a product,
a figure or a public function of an application is gone once its line is gone.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, TypeVar

from .application import Application

if TYPE_CHECKING:
    from ..config.study import Config

T = TypeVar("T")
FOLDERS = (
    "statics",
    "histories",
    "tolerances",
    "requirements",
    "spectra",
    "electrode",
    "window",
    "calibration",
    "design",
    "datasheet",
    "boundary",
    "laws",
    "stress",
    "page",
)
"""Each after those whose results it reads."""


def attached() -> dict[str, Application]:
    """Import the applications; returns them by the names of their folders."""
    return {folder: import_module(f"{__name__}.{folder}").application for folder in FOLDERS}


def gather(ask: Callable[[Application], T | None]) -> dict[str, T]:
    """Ask each application; returns what is not empty, by folder."""
    answers = {folder: ask(application) for folder, application in attached().items()}
    return {folder: answer for folder, answer in answers.items() if answer}


def merge(ask: Callable[[Application], Mapping[str, T]]) -> dict[str, T]:
    """Ask each application; returns the union of the mappings."""
    return {k: v for answer in gather(ask).values() for k, v in answer.items()}


def observers() -> list[Callable]:
    """Return what sees each cell of a cube."""
    return [application.observe for application in attached().values()]


def refuse_all(study: "Config") -> None:
    """Refuse a study before its first job; a ValueError, one line, names the key."""
    for key, application in attached().items():
        try:
            application.refuse(study)
        except ValueError as error:
            raise ValueError(f"{key}: {error}") from None
