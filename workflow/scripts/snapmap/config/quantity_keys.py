"""The keys of a config that are quantities or take a shape by name, as parts of its schema."""

from ..axes import COORDINATES, axis_behind
from ..device import BEAM_VALUES, CLAMP, STOPS, VALUES
from ..pulse import SHAPES
from ..quantities import QUANTITIES
from ..tolerances.samples import OF_DEVICE


def write_out(schema: dict) -> None:
    """Complete the keys that are quantities or shapes; what the schema itself says stays."""
    parts, kinds = schema["properties"], schema["$defs"]
    of_beam = [key for key in VALUES if key in BEAM_VALUES and key not in CLAMP.values()]
    apart = *BEAM_VALUES, *STOPS.values(), "temperature"
    of_device = [key for key in VALUES if key not in apart]
    rare_last = sorted(VALUES, key=lambda key: QUANTITIES[key].left_out is not None)
    for section, keys, write in (
        (kinds["device"]["properties"]["beam"], of_beam, _own),
        (kinds["device"], of_device, _own),
        (parts["sweep"], rare_last, _axis),
        (parts["tolerances"], [key for key in rare_last if key in OF_DEVICE], _scatter),
        (parts["calibration"]["properties"]["unknowns"], rare_last, _range),
        (parts["histories"]["items"], rare_last, _instead),
    ):
        given = _in_order(section["properties"], keys)
        section["properties"] = {key: _added(key, kinds, write) | own for key, own in given}
    kinds["axis_name"]["enum"] = [key for key in QUANTITIES if axis_behind(key) in COORDINATES]
    names = f"one of {', '.join(SHAPES)}"
    kinds["shape"] = {"enum": [*SHAPES], "description": names}
    parts["requirements"]["items"]["properties"]["shape"]["description"] = names
    or_several = f"{names}, or a list of these, which then is an axis"
    parts["pulse"]["properties"]["shape"]["description"] = or_several


def _in_order(given, keys):
    """The keys of a section and their parts; at `*` those of `keys` that it does not name."""
    for key, part in given.items():
        if key == "*":
            yield from ((other, part.get(other, {})) for other in keys if other not in given)
        else:
            yield key, part


def _added(key, kinds, write):
    """What is known of a key, if its values are of one of the kinds."""
    quantity = QUANTITIES.get(key)
    return write(quantity, kinds[quantity.kind]) if quantity and quantity.kind in kinds else {}


def _own(quantity, kind):
    return {
        "type": kind["type"],
        "format": quantity.kind,
        "description": f"{kind['description']}: {quantity.long_name}",
    }


def _axis(quantity, kind):
    value = {"$ref": f"#/$defs/{quantity.kind}"}
    return {
        "$ref": "#/$defs/axis",
        "description": f"a list or a range of {kind.get('several')}, each in place of the device's "
        "own",
        "items": value,
        "properties": {"from": value, "to": value},
    }


def _scatter(quantity, kind):
    width = kind["description"].partition(" >")[0]
    text = f"a standard deviation, as {width} or a share, or a mapping of its kind to its width"
    return {"$ref": "#/$defs/scatter", "description": text}


def _range(quantity, kind):
    return {
        "type": "array",
        "minItems": 2,
        "maxItems": 2,
        "items": {"$ref": f"#/$defs/{quantity.kind}"},
        "description": f"a pair of {kind.get('several', kind['description'])}: where it is looked "
        "for",
    }


def _instead(quantity, kind):
    text = f"{kind['description']}, in place of the device's"
    return {"$ref": f"#/$defs/{quantity.kind}", "description": text}
