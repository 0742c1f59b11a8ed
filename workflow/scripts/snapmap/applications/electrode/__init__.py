"""A contact that the beam's midpoint closes, as an observer.  Imports: requirements."""


def kinds():
    """Required shocks that must close it, by the keys that they alone have."""
    from .required import DEMANDS, ClosingSection

    return dict.fromkeys(DEMANDS, ClosingSection)


def described():
    """Its section, as docs/config.md has it."""
    from .required import ClosingSection

    return {"each of requirements, with an electrode": ClosingSection}


def request(section, study, document):
    """Nothing; ValueError where only some devices have one."""
    if len({bool(device.has_electrode) for device in study.devices().values()}) > 1:
        need = "only some devices have it; write it for all or for none"
        raise ValueError(f"device.contact_at: {need}")


def observe(model, cells, observed, settings):
    """When each cell closes it, and for how long."""
    from .closures import closures_again

    if not model.device.has_electrode.any():
        return {}
    return closures_again(model, cells, observed, settings)


def observing(model, cells, settings):
    """The time of two more runs of each cell."""
    from ...solver.cost import steps_and_seconds
    from ...solver.outcome import REPEATED_STEP

    if not model.device.has_electrode.any():
        return 0.0
    moved = steps_and_seconds(model, cells, settings._replace(until="moved"))[1]
    return (1 + 1 / REPEATED_STEP) * moved


def in_history(model, cells, settings):
    """Its place, and when a cell closes it and for how long."""
    from .closures import follow_closures

    if not model.device.has_electrode:
        return {}
    closures = follow_closures(model, cells, cells.t_end, settings).items()
    return {"contact_at": model.device.contact_at} | {key: value.item() for key, value in closures}


def in_statics(device, first, displacement, force):
    """Its place, and the force with which the beam rests on it: 0 where it does not."""
    import numpy as np

    if not device.has_electrode:
        return {}
    held = np.interp(first - device.contact_at, displacement, -force)
    # What is not known is not 0.
    return {"contact_at": device.contact_at, "hold_force": float(np.maximum(held, 0.0))}


def in_datasheet(study, rows):
    """What it sees under the worst of required shocks, with its error."""
    from .sheet import sections

    return sections(study, rows)
