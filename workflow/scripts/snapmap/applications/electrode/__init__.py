"""An electrode that the beam's midpoint closes, without a force on it.  Imports: requirements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..application import Application, Config

if TYPE_CHECKING:
    import numpy as np

    from ...device.device import Device
    from ...solver.cells import Cells, Observations
    from ...solver.models import Follows
    from ...solver.settings import Run
    from ...study.study import Study
    from ..requirements.verdict import Verdict


class Electrode(Application):
    def kinds(self) -> Mapping[str, Any]:
        """The section of shocks that must close the electrode, by keys that only it has."""
        from .required import DEMANDS, ClosingSection

        return dict.fromkeys(DEMANDS, ClosingSection)

    def request(self, section: Any, study: Config, document: Any) -> Any:
        """None; ValueError, one line, if only some devices have an electrode."""
        if len({bool(device.has_electrode) for device in study.devices().values()}) > 1:
            raise ValueError(
                "device.contact_at: only some devices have it; write it for all or for none"
            )

    def observe(
        self, model: Follows, cells: Cells, observed: Observations, settings: Run
    ) -> dict[str, np.ndarray]:
        """The closures of each cell, by name, with their errors; empty without an electrode."""
        from .closures import closures_again

        if not model.device.has_electrode.any():
            return {}
        return closures_again(model, cells, observed, settings)

    def in_history(self, model: Follows, cells: Cells, settings: Run) -> dict[str, Any]:
        """The place of the electrode, and the closures of a cell; empty without an electrode."""
        from .closures import follow_closures

        if not model.device.has_electrode:
            return {}
        closures = follow_closures(model, cells, cells.t_end, settings)
        values = {key: value.item() for key, value in closures.items()}
        return {"contact_at": model.device.contact_at, **values}

    def in_statics(
        self, device: Device, first: float, displacement: np.ndarray, force: np.ndarray
    ) -> dict[str, Any]:
        """Place of the electrode, um, and the force of the beam on it, uN; 0 without contact."""
        import numpy as np

        if not device.has_electrode:
            return {}
        held = np.interp(first - device.contact_at, displacement, -force)
        # np.maximum keeps NaN.
        return {"contact_at": device.contact_at, "hold_force": float(np.maximum(held, 0.0))}

    def in_datasheet(self, study: Study, verdicts: Sequence[Verdict]) -> list[str]:
        """A table of the closures under the worst corner of each required shock."""
        from .closures import sections

        return sections(study, verdicts)


application = Electrode()
