"""Kinds of text in a config: titles, paths, and amplitudes of a shape."""

from typing import Annotated

from typing_extensions import TypeAliasType

from ..device.curved_beam import COSINES
from ..files.named import inside
from ..files.text import describe, is_title
from ..values.kinds import Kind, Quantity, read_each


class TitleKind(Kind):
    """A title."""

    need = "a line of letters, digits, spaces, .,:()/%+-_, at most 60"

    def read(self, value: object) -> str:
        """Read a title."""
        if not is_title(value):
            raise ValueError(f"{describe(value)} is not {self.need}")
        return value

    def schema(self) -> dict:
        """Describe text."""
        return {"type": "string", "maxLength": 60}


Title = TypeAliasType("Title", Annotated[str, TitleKind()])


class AmplitudesKind(Kind):
    """Amplitudes of cosines."""

    need = f"a list of up to {len(COSINES) + 1} plain numbers"

    def read(self, value: object) -> list[float]:
        """Read a list of numbers."""
        if not isinstance(value, list | tuple) or not 0 < len(value) <= len(COSINES) + 1:
            raise ValueError(f"{describe(value)} is not {self.need}")
        return read_each(Quantity("a plain number", "", "0.1", "(-inf, inf)"), value)

    def schema(self) -> dict:
        """Describe a list of numbers."""
        return {"type": "array", "items": {"type": "number"}, "minItems": 1, "maxItems": 5}


class PathKind(Kind):
    """The path of a file in the study's folder."""

    need = "the path of a file in the study's folder"

    def read(self, value: object) -> str:
        """Read a path."""
        if not (isinstance(value, str) and value):
            raise ValueError(f"{describe(value)} is not {self.need}")
        return inside(value)

    def schema(self) -> dict:
        """Describe a path."""
        return {"type": "string"}


StudyPath = TypeAliasType("StudyPath", Annotated[str, PathKind()])
Amplitudes = TypeAliasType("Amplitudes", Annotated[list[float], AmplitudesKind()])
