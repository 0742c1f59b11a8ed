"""Kinds of paths."""

from os import PathLike
from os.path import exists
from typing import Annotated

from typing_extensions import TypeAliasType

from .kinds import Fitting


def _is_there(value):
    return isinstance(value, str | PathLike) and "\0" not in str(value) and exists(value)


_PATH = Fitting("the path of a file that is there", _is_there)
ExistingPath = TypeAliasType("ExistingPath", Annotated[str | PathLike, _PATH])
