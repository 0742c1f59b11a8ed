"""The requirements of a study."""

from collections.abc import Sequence

from ...config.keys import in_list
from ...config.study import Config, require_start
from ...files.text import show
from ...solver.settings import FIRST
from .required import Required


def read_requirements(sections: Sequence, study: Config, pulse) -> list[Required]:
    """Take the requirements of a config; ValueError, one line, for one that cannot be.

    pulse: the section of the study's pulse, or nothing
    """
    names = [section.name for section in sections]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"{show(twice)} comes twice; write another")
    required = []
    for place, section in enumerate(sections):
        try:
            required.append(section.under(pulse))
            start = required[-1].values.get("start", FIRST)
            for device in study.devices().values():
                require_start(start, device)
        except ValueError as error:
            raise ValueError(in_list(place, str(error))) from None
    if required:
        at = study.temperatures
        study.set_out({"temperature": at} if at else {})
    for one in required:
        one.require(study)
    return required
