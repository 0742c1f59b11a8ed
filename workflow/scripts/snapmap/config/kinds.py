"""Kinds of text in a config: paths, and amplitudes of a shape."""

from typing import Annotated

from ..device.curved_beam import COSINES
from ..files.named import inside
from ..values.kinds import JSON_TEXT, Fitting, Items, kind_of
from ..values.quantities import Part

MOST = len(COSINES) + 1
"""Most amplitudes of a shape."""


def _is_path(value):
    return isinstance(value, str) and value


PATH = Fitting("the path of a file in the study's folder", _is_path, inside, json=JSON_TEXT)
StudyPath = Annotated[str, PATH]


def _are_few(value):
    return isinstance(value, list | tuple) and 0 < len(value) <= MOST


_AMPLITUDES = Items(kind_of(Part))
_NUMBERS = {"type": "array", "items": {"type": "number"}, "minItems": 1, "maxItems": MOST}
_FEW = Fitting(f"a list of up to {MOST} plain numbers", _are_few, _AMPLITUDES.read, json=_NUMBERS)
Amplitudes = Annotated[list[float], _FEW]
