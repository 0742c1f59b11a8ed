"""The rows of the work array; docs/theory.md, section "Symbols", explains each.

The state and coefficients of all running cells are in a single flat array, with a row of LANES
numbers for each symbol. Time is counted in steps, and forces are times dt^2. Modules import this
one as R: X[R.Y, l] is y of lane l, V[R.P, i, l] is component i of p, and V[R.S + i, j, l] is S_ij.
"""

import numpy as np

LANES = 16
Rows = np.ndarray
Shape = tuple[int, ...]
"""What says the number of modes by its length."""

# Rows of one number: the device's; the cell's; scratch; from STATE on, the state at instant n.
AXIAL, RESIDUAL, CONTACT, M, K, TARGET, BARRIER, BARRIER_APART, SADDLE = range(9)
Z0, ALPHA, STOP_TOWARD, STOP_AWAY, RESTITUTION = range(9, 14)
TABLE, REACH, SIDE = 14, 16, 17
AMPLITUDE, KEEP, B, BEAM_KEEP, BEAM_B = range(18, 23)
X_STEP, PIECE = 23, 24
BEGIN, START, SLOPE, TURNS, LIFT, SWING, TURN, PULSE, PULSE_STEP, PULSE_LEFT = range(24, 34)
HALF_CONTACT, GAMMA, SOFTENING, COMPLIANCE, HELD = range(34, 39)
A, EP, DY_FREE, OVERLAP_FREE, BETA = range(39, 44)
Q_FREE, INVERSE, EU, FORCE, SWITCHES = range(44, 49)
LAST_SWING, SINCE, BEYOND_SINCE, WORST, AT_START, LOWEST = range(49, 55)
# C and dt; of a user's laws; TABLE, and rows from PER on, are two, of contact and force.
C, DT, YIELDS, DRAG, DY_BEFORE, LOW, HIGH, FAR, FREE, HOLD = range(55, 65)
PER, PLACE, SHARE, MISS, GUESS, FROM, RISE, PUSH, PUSH_BEFORE = range(65, 83, 2)
ENERGY, ENERGY_BEFORE, CUBIC = 83, 85, 87
# SHORT: whether the steps are those after a snap.
SHORT, STATE = 95, 96
Y, DY, Q, OVERLAP = range(96, 100)
W_BEFORE, W, COUNT, WORK, GROSS_WORK, SWEPT, BEAM_SWEPT, BEYOND, LOST = range(100, 109)
# Vectors of k rows, from row VECTORS on: the state; scratch; the device's; S, k vectors.
VECTORS = 109
P, D, U, D_FREE, KAPPA, SQ0, F, E, S = range(9)
