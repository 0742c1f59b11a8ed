"""The words of captions: what a dataset was made with, in lines that fit a figure."""

import textwrap
from collections.abc import Iterable, Mapping

from ..files.text import plain
from ..pulse.pulse import NEAR_G, VERSED_SINE, G
from ..pulse.shocks import MAKERS
from ..solver.settings import FIRST
from ..study.provenance import config_of
from ..values.units import used

PAGE = 130
"""Most signs in a line over two columns."""
HARD = "\u00a0"
"""A space at which no line breaks."""


def case(attributes: Mapping[str, str], width: int = PAGE) -> str:
    """Write pulse, guide, start, model and horizon of a dataset, in lines of `width` signs."""
    if "config" not in attributes:
        return ""
    config = config_of(attributes)
    pulse = config.get("pulse", {})
    made = next((key for key in MAKERS if key in pulse), VERSED_SINE)
    shape = pulse.get("file", pulse.get("shape", made))
    words = [literal(shape)] if isinstance(shape, str) else []
    if pulse.get("direction") == "-z":
        words.append("along −z")
    words += [*guides(config), *starts(config)]
    if "model" in config:  # a cube of open slabs has none
        words.append(f"model {config['model']['name']}")
    if horizon := config.get("run", {}).get("horizon"):
        time, _, unit = horizon.partition(" ")
        horizon = f"{plain(float(time) / 1e3)} ms" if unit == "us" else horizon
        words.append(f"followed {horizon}")
    return fill(words, width)


def fill(phrases: Iterable[str], width: int, mark: str = ", ") -> str:
    """Join phrases with a mark, in lines of at most `width` signs that break between phrases."""
    kept = (phrase.replace(" ", HARD) for phrase in phrases)
    return textwrap.fill(mark.join(kept), width, break_long_words=False).replace(HARD, " ")


def literal(text: str) -> str:
    """Escape a user's text, so that a dollar begins no formula."""
    return text.replace("$", r"\$")


def starts(config: Mapping) -> list[str]:
    """Say whether the runs of a config start in the second shape; [] if they do not."""
    start = config.get("run", {}).get("start", FIRST)
    return [] if start == FIRST else ["starts in the second shape"]


def guides(config: Mapping) -> list[str]:
    """Say whether the beams of a config are guided or free to tilt; [] if they differ."""
    free = {bool(device["beam"].get("free")) for device in _devices(config)}
    words = {False: "guided beam", True: "beam free to tilt"}
    return [words[free.pop()]] if len(free) == 1 else []


def multiples(attributes: Mapping[str, str]) -> str:
    """Say what N counts by a dataset's attributes: g, gravity, or a force on the midpoint."""
    devices = _devices(config_of(attributes))
    forces = {device["force"] for device in devices if "force" in device}
    if not forces:
        gravity = devices[0].get("gravity", "") if devices else ""
        is_g = not gravity or abs(float(gravity.partition(" ")[0]) / G - 1) < NEAR_G
        counted = used(gravity, "m/s^2", typeset=True)
        return f"multiples of {'$g$' if is_g else counted}"
    size = plain(float(forces.pop().partition(" ")[0]))
    return "multiples of each force" if forces else f"multiples of {size} µN"


def _devices(config):
    """List the sections of a config's devices."""
    if "devices" in config:
        return list(config["devices"].values())
    return [config["device"]] if "device" in config else []
