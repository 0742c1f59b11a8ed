"""Kinds of the arguments that several public functions share."""

from collections.abc import Mapping, Sequence
from typing import Annotated

from ..device.device import VALUES, Device
from ..values.kinds import Fitting, Items, Several, kind_of
from ..values.quantities import Value
from ..values.records import ByKeys, row_of_kinds
from .axes import KIND_OF
from .shock import Requirement
from .study import DEVICES, Study


def _study(value):
    return value if isinstance(value, Study) else Study(DEVICES.take(value))


def _single(value):
    study = _study(value)
    if isinstance(study.device, Mapping):
        raise _SINGLE.refuse(study.device)
    if len(study.shocks.pulses) > 1:
        raise ValueError(".pulse: has several shapes or directions; write one of each")
    return study


def _is_study(value):
    return isinstance(value, Study | Device | Mapping)


_STUDY = Fitting(f"a Study, or {DEVICES.need}", _is_study, _study)
_ONE = "a Study of a single Device, or a Device; load_device reads one"
_SINGLE = Fitting(_ONE, _is_study, _single)
AnyStudy = Annotated[Study | Device | Mapping[str, Device], _STUDY]
SingleStudy = Annotated[Study | Device, _SINGLE]

_WORDS = "values in place of the device's own, a list or a range"
AxesOfDevice = row_of_kinds(
    "AxesOfDevice", {key: (Annotated[object, Several(KIND_OF[key])], _WORDS) for key in VALUES}
)
_AXES = 'a mapping of values of the device, such as {"thickness": [1.9, 2.0]}'
_NO_AXIS = "is not a value of the device that can vary"
_VALUES = ByKeys(AxesOfDevice, _AXES, _NO_AXIS)
Axes = Annotated[Mapping[str, float | str | Sequence], _VALUES]
Requirements = Annotated[Value, Items(kind_of(Requirement))]
