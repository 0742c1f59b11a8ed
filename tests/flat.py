"""Calls of the public functions with the values of their study written beside the arguments.

`flat.sweep(device, N, f0, C, model="cosines", modes=3, until="snap", thickness=[1.9, 2.0])` makes
the study, and the axes, that `snapmap.sweep` takes.
"""

from dataclasses import fields

import snapmap
from snapmap.device.device import VALUES
from snapmap.solver.options import MODELS, ModelKind

RUN = {field.name for field in fields(snapmap.Run)}


def model(name, **options):
    """Make the model of a name and options."""
    return ModelKind().take({"name": name, **options})


def study(device, chosen="auto", values=None):
    """Make a study of a device, a model and values by name, which are taken out."""
    values = {} if values is None else values

    def take(names):
        return {key: values.pop(key) for key in [*values] if key in names}

    options = {field.name for made in MODELS.values() for field in fields(made)}
    options = take(options)
    chosen = model(chosen, **options) if isinstance(chosen, str) else ModelKind().take(chosen)
    return snapmap.Study(
        device,
        model=ModelKind().take(chosen),
        run=take(RUN),
        **take(("pulse", "direction", "skip")),
    )


def _flat(name, *arguments):
    function = getattr(snapmap, name)

    def call(device, *positional, **values):
        values |= dict(zip((*arguments, "model"), positional, strict=False))
        own = {key: values.pop(key) for key in [*values] if key in arguments}
        if name in ("threshold", "tolerance") and "tolerance" in values:
            own["tolerance" if name == "threshold" else "threshold_tolerance"] = values.pop(
                "tolerance"
            )
        asked = study(device, values.pop("model", "auto"), values)
        axes = {key: values.pop(key) for key in [*values] if key in VALUES}
        return function(asked, **own, **values, **({"axes": axes} if axes else {}))

    return call


sweep = _flat("sweep", "N", "f0", "C")
threshold = _flat("threshold", "f0", "C")
simulate = _flat("simulate", "N", "f0", "C")
tolerance = _flat("tolerance", "scatters", "f0", "C", "N")
design = _flat("design", "value", "N", "f0", "C", "between")
calibrate = _flat("calibrate", "shots", "unknowns", "C")
vibration = _flat("vibration", "psd", "duration", "C")
srs_test = _flat("srs_test", "srs", "C")
