"""Faults of a config: every one is found, and all are reported at once."""

from collections.abc import Callable, Mapping

from .schema import order_of
from .yaml_file import ConfigError

Place = tuple[str | int, ...]
Faults = dict[Place, str]
"""A line for each place of a document at which something is wrong."""


def convert_part(
    document: Mapping, path: Place, faults: Faults, convert: Callable, *options: object
) -> object:
    """Convert the section at `path` unless it is faulty; a ValueError joins `faults`, for None."""
    if any(at[: len(path)] == path[: len(at)] for at in faults):
        return None
    for key in path:
        document = document[key]
    try:
        return convert(document, *options)
    except ValueError as error:
        faults[path] = str(error)
    return None


def refuse(faults: Faults) -> None:
    """Raise ConfigError with every fault, in the order of the config, if there is one."""
    if faults:
        raise ConfigError(*(faults[path] for path in sorted(faults, key=order_of)))
