"""Random vibration and shock response spectra.  Imports: requirements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..application import Application


class Spectra(Application):
    public = ("vibration.vibration", "trips.srs_test")

    def kinds(self) -> Mapping[str, Any]:
        """Sections of requirements, by the key that only they have."""
        from .sections import SpectrumSection, VibrationSection

        return {"psd": VibrationSection, "srs": SpectrumSection}

    def described(self) -> Mapping[str, Any]:
        """Its sections, as docs/config.md has them."""
        from .sections import SpectrumSection, VibrationSection

        return {
            "each of requirements, with psd": VibrationSection,
            "each of requirements, with srs": SpectrumSection,
        }


application = Spectra()
