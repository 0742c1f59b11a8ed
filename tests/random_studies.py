"""Small studies of combined features, made at random from a seed."""

import random

import yaml

from snapmap.applications.whole import load_config
from snapmap.workflow.plan import core_seconds, make_plan

MOST_SECONDS = 15
"""Largest forecast of core time of a study that is drawn."""
RECORD = "t (us),a (g)\n0,0\n50,800.5\n100,1500\n150,900\n200,0\n"
SHOTS = "N,duration (ms),tripped\n700,0.913,no\n1500,0.913,yes\n1100,0.913,no\n1300,0.913,yes\n"
POINTS = "N,f0 (Hz),name,snapped\n812.5,1234.5,a first one,yes\n1999,800,b,no\n"
FILES = {"record.csv": RECORD, "shots.csv": SHOTS, "points.csv": POINTS}
SHAPES = "versed sine", "half sine", "sawtooth", "trapezoid"
AXES = {
    "span": (480, 520, "um"),
    "rise": (7.5, 8.5, "um"),
    "thickness": (1.8, 2.0, "um"),
    "depth": (18, 22, "um"),
    "mass": (5e-9, 8e-9, "kg"),
    "spring": (3, 6, "N/m"),
    "gap": (0, 1, "um"),
    "contact": (30, 80, "N/m"),
    "temperature": (-40, 125, "degC"),
    "residual_stress": (-2, 2, "MPa"),
}
"""Values of the device that become axes, each between two ends."""
KINDS = *["switch"] * 3, *["electrode"] * 2, "free", "stops", "alone", "pushed"
OF_MASS = "mass", "spring", "gap", "contact"


def random_study(seed):
    """A config as YAML: one that is refused, or takes little time by its forecast.

    The files that it names are FILES.
    """
    draws = random.Random(seed)
    while True:
        text = yaml.safe_dump(Drawn(draws).document(), sort_keys=False, default_flow_style=None)
        try:
            if _seconds(load_config(yaml.safe_load(text))) <= MOST_SECONDS:
                return text
        except ValueError:
            return text


def _seconds(study):
    return core_seconds(study, make_plan(study))


class Drawn:
    """The sections of a config, drawn in turn."""

    def __init__(self, draws):
        self.draws = draws
        self.kind = draws.choice(KINDS)
        self.has_mass = self.kind not in ("alone", "pushed")
        self.scale = {"alone": 60, "pushed": 0.1}.get(self.kind, 1)

    def maybe(self, share, value, default=None):
        return value if self.draws.random() < share else default

    def some(self, options):
        return {key: value for key, value in options.items() if self.maybe(0.2, True)}

    def value(self, low, high, unit=""):
        """A value with decimals between two ends, with its unit."""
        number = f"{self.draws.uniform(low, high):.{self.draws.choice([2, 3, 5, 7])}g}"
        return f"{number} {unit}".strip() if unit else float(number)

    def axis(self, low, high, unit="", points=2):
        """A list, or a linear or logarithmic range, of values."""
        if self.draws.random() < 0.4 and low > 0:
            ends = {
                "from": self.value(low, 1.2 * low, unit),
                "to": self.value(high, 1.2 * high, unit),
            }
            return ends | {"points": points, "spacing": self.draws.choice(["linear", "log"])}
        middle = (low + high) / 2
        return [self.value(low, middle, unit), self.value(middle + 1e-3 * abs(middle), high, unit)]

    def document(self):
        document = {"title": "A random study, by its seed"} if self.maybe(0.3, True) else {}
        device = self.device()
        if self.maybe(0.2, True):
            other = device | {"beam": device["beam"] | {"thickness": self.value(1.8, 2, "um")}}
            document["devices"] = {"first": device, "the_other-1": other}
        else:
            document["device"] = device
        document["model"] = {"name": "cosines", "modes": 3}
        if pulse := self.pulse():
            document["pulse"] = pulse
        document["sweep"] = sweep = self.sweep(pulse)
        document |= self.run()
        over = [key for key in sweep if key in AXES or key == "C"]
        if len(over) > 1 and self.maybe(0.3, True):
            document["maps"] = [{"x": over[0], "y": over[1]}, {"x": over[1], "y": "N"}]
        if over and self.maybe(0.2, True):
            document["thresholds"] = [{"x": "f0", "lines": over[0]}]
        if self.kind != "pushed" and self.maybe(0.2, True):
            document["marks"] = "points.csv"
        if self.maybe(0.5, True):
            document["requirements"] = self.requirements()
        if self.maybe(0.25, True):
            document["tolerances"] = self.tolerances()
        if self.has_mass and self.maybe(0.2, True):
            unknowns = {"thickness": [self.value(1.7, 1.8, "um"), self.value(2, 2.1, "um")]}
            document["calibration"] = {
                "shots": "shots.csv",
                "unknowns": unknowns,
                "C": self.damper(),
            }
        if self.maybe(0.4, True):
            cells = [self.history() for _ in range(self.draws.choice([1, 2]))]
            document["histories"] = cells + self.maybe(0.05, cells[:1], [])
        if self.maybe(0.25, True):
            document["laws"] = True
        return document

    def damper(self):
        return self.value(0.5, 60, "uN*us/um")

    def device(self):
        beam = {"span": "500 um", "rise": self.value(7.5, 8.5, "um"), "thickness": "1.9 um"}
        beam |= {"depth": "20 um", "youngs_modulus": "160 GPa", "density": "2330 kg/m^3"}
        if self.maybe(0.5, True):
            beam["damping"] = self.value(1e-3, 5e-3, "/us")
        if self.kind == "free":
            beam |= {"free": True, "imperfection": self.value(0.01, 0.05, "um")}
            beam |= {"rise": self.value(10, 11, "um"), "thickness": self.value(1.2, 1.4, "um")}
        device = {"beam": beam, "mass": "none"}
        if self.has_mass:
            device |= {"mass": self.value(5e-9, 8e-9, "kg"), "spring": self.value(3, 6, "N/m")}
            device["contact"] = self.maybe(0.2, "hard", self.value(30, 80, "N/m"))
        if self.kind == "pushed":
            return device | {"force": "1 uN"}
        device["gravity"] = "9.81 m/s^2"
        if self.kind == "stops":
            device["stop_toward"] = self.value(18, 25, "um")
            device["stop_away"] = self.value(4, 9, "um")
        if self.kind == "electrode":
            device["contact_at"] = self.value(-6, -3, "um")
        if self.maybe(0.3, True):
            weibull = {"strength": self.value(1, 3, "GPa"), "strength_modulus": 10}
            device |= self.maybe(0.4, weibull, {"strength": self.value(0.8, 2, "GPa")})
        if self.maybe(0.2, True):
            device |= {"modulus_slope": "-63e-6 /K", "expansion_mismatch": "2.3e-7 /K"}
            device["damper_exponent"] = 0.7
        return device

    def pulse(self):
        blows = [{"duration": "0.4 ms"}, {"wait": "0.5 ms"}, {"repeat": 2}]
        kinds = [{}, {"shape": self.draws.choice(SHAPES)}, {"shape": self.draws.sample(SHAPES, 2)}]
        kinds.append({"train": blows})
        if self.kind != "pushed":  # else nothing shakes the frame
            kinds += [{"file": "record.csv"}, {"drop": self.drop()}]
        pulse = self.draws.choice(kinds)
        return pulse | self.maybe(0.3, {"direction": self.draws.choice(["-z", "both"])}, {})

    def drop(self):
        """From so low that the free fall takes few steps."""
        fall = {"height": self.value(0.1, 0.5, "mm"), "duration": self.value(0.1, 0.4, "ms")}
        return fall | self.maybe(0.5, {"rebound": 0.25}, {})

    def sweep(self, pulse):
        N = {"from": self.value(200 * self.scale, 500 * self.scale), "points": 3}
        sweep = {"N": N | {"to": self.value(2000 * self.scale, 4000 * self.scale)}}
        if self.maybe(0.3, True):
            sweep["N"]["spacing"] = "log"
        if not {"file", "train", "drop"} & {*pulse}:
            kinds = ("duration", 0.2, 0.5, "ms"), ("f0", 900, 2500, "Hz")
            key, *ends = self.draws.choice(kinds)
            sweep[key] = self.maybe(0.3, [self.value(*ends)], self.axis(*ends))
        if self.has_mass:
            sweep["C"] = self.maybe(0.5, [self.damper()], self.axis(0.5, 60, "uN*us/um"))
        known = [key for key in AXES if self.has_mass or key not in OF_MASS]
        for key in self.draws.sample(known, self.draws.choice([0, 0, 1, 1, 2])):
            sweep[key] = self.axis(*AXES[key])
        return sweep

    def run(self):
        run = {"horizon": self.value(100, 300, "us")}
        run |= self.some({"until": "snap", "repeat": False})
        skip = self.some({"skip": True})
        run |= {} if self.kind == "free" else self.some({"start": "second"})
        return {"run": run} | skip

    def requirements(self):
        N, time = self.value(500 * self.scale, 3000 * self.scale), self.value(0.2, 0.6, "ms")
        snaps = self.maybe(0.5, True, False)
        shock = {"name": "a crash, 1.5 m", "shape": "half sine", "N": N, "duration": time}
        kinds = [shock | {"snaps": snaps, "survives": self.maybe(0.3, "99.9 %", True)}]
        kinds.append(shock | {"direction": "-z", "snaps": self.maybe(0.3, "any", snaps)})
        kinds.append(shock | {"shape": ["sawtooth", "trapezoid"], "snaps": snaps})
        if self.kind == "electrode":
            closing = self.draws.choice(["closes_within", "stays_closed"])
            kinds = [shock | {"snaps": True, closing: self.value(0.3, 1, "ms")}]
        elif self.kind != "pushed":
            kinds.append({"name": "recorded", "file": "record.csv", "N": N, "snaps": snaps})
            kinds.append({"name": "dropped", "drop": self.drop(), "snaps": snaps})
            levels = [["500 Hz", self.value(100, 300, "g")], ["5 kHz", self.value(100, 300, "g")]]
            kinds.append({"name": "spectrum", "srs": levels, "snaps": snaps})
            levels = [["100 Hz", "0.1 g^2/Hz"], ["2 kHz", self.value(0.05, 0.2, "g^2/Hz")]]
            kinds.append({"name": "shaken", "psd": levels, "duration": "10 ms", "snaps": False})
        count = min(len(kinds), self.draws.choice([1, 1, 2]))
        chosen = self.draws.sample(kinds, count)
        return [each | {"name": f"{each['name']} {i}"} for i, each in enumerate(chosen)]

    def tolerances(self):
        made = {"thickness": self.draws.choice(["0.02 um", "1.5 %", {"uniform": "0.03 um"}])}
        made |= self.maybe(0.5, {"N": "2 %"}, {}) | self.maybe(0.5, {"depth": "1 %"}, {})
        return made | {"samples": 8, "index_samples": 4, "seed": self.draws.randrange(99)}

    def history(self):
        N = self.value(500 * self.scale, 3000 * self.scale)
        cell = {"N": N, "f0": self.value(900, 2500, "Hz")}
        cell |= {"C": self.damper()} if self.has_mass else {"C": "0 uN*us/um"}
        known = [key for key in AXES if self.has_mass or key not in OF_MASS]
        changed = self.draws.sample(known, self.draws.choice([0, 0, 1, 5]))
        return cell | {key: self.value(*AXES[key]) for key in changed}
