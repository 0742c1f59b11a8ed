"""Kinds of paths."""

from os import PathLike
from os.path import exists
from typing import Annotated

from typing_extensions import TypeAliasType

from ..files.text import show
from .kinds import Fitting


def _take_path(value):
    if not isinstance(value, str | PathLike) or "\0" in str(value) or not exists(value):
        raise ValueError(f"{show(value)} is not the path of a file that is there")
    return value


ExistingPath = TypeAliasType(
    "ExistingPath",
    Annotated[str | PathLike, Fitting("the path of a file that is there", _take_path)],
)
