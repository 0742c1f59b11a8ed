"""Random vibration and shock response spectra.  Imports: requirements."""

public = {"vibration": "vibration", "srs_test": "trips"}


def kinds():
    """Sections of requirements, by the key that only they have."""
    from .sections import SpectrumSection, VibrationSection

    return {"psd": VibrationSection, "srs": SpectrumSection}


def described():
    """Its sections, as docs/config.md has them."""
    from .sections import SpectrumSection, VibrationSection

    return {
        "each of requirements, with psd": VibrationSection,
        "each of requirements, with srs": SpectrumSection,
    }
