"""What several tests study."""

from pathlib import Path

TINY = (Path(__file__).parents[1] / ".test" / "config" / "config.yaml").read_text()

THREE_COSINES = """
device:
  beam: {span: 600 um, rise: 10 um, thickness: 2 um, depth: 22 um, youngs_modulus: 150 GPa,
         density: 2330 kg/m^3}
  mass: 1e-8 kg
  spring: 5.5 N/m
  contact: 40 N/m
  gravity: 9.81 m/s^2
model: {name: cosines, modes: 3}
"""
"""The handout's device with its cheapest model; a sweep is to be added."""
