"""What a study needs for its requirements."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...study.study import ANY, CLOSING, Study


def require_shock(study: Study, required: Mapping) -> None:
    """Raise ValueError where a device lacks what a required shock needs."""
    devices = study.devices().values()
    closing = next((key for key in CLOSING if key in required), None)
    if closing and not any(device.has_electrode for device in devices):
        need = "write the place of the electrode, such as '-5 um'"
        raise ValueError(f"device.contact_at: missing, for {closing}; {need}")
    unbreakable = any(np.isinf(device.strength) for device in devices)
    if required["snaps"] == ANY and not closing and unbreakable:
        need = "write one such as '1.2 GPa', or closes_within in the requirement"
        raise ValueError(f"device.strength: missing, for snaps: any of {required['name']}; {need}")
    replace(study, shocks=required["shocks"])  # a force shakes no frame
