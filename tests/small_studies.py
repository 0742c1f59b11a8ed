"""What several tests study."""

TINY = """
device:
  beam: {span: 500 um, rise: 8 um, thickness: 1.9 um, depth: 20 um, youngs_modulus: 160 GPa,
         density: 2330 kg/m^3}
  mass: 6e-9 kg
  spring: 4 N/m
  contact: 60 N/m
  gravity: 9.81 m/s^2
model: {name: handout, elements: 3}
sweep:
  N: {from: 200, to: 3000, points: 8}
  f0: [800 Hz, 2 kHz]
  C: [0.5 uN*us/um, 30 uN*us/um]
  horizon: 200 us
"""
"""A device unlike the handout's, in a study that is over in seconds."""

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
