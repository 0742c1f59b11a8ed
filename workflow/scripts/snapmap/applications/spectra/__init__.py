"""Random vibration and shock response spectra.  Imports: requirements."""

from collections.abc import Mapping
from typing import Any

from ..application import Application


class Spectra(Application):
    def kinds(self) -> Mapping[str, Any]:
        """Sections of requirements, by the key that only they have."""
        from .required import RequiredSpectrum, RequiredVibration

        return {"psd": RequiredVibration, "srs": RequiredSpectrum}


application = Spectra()
