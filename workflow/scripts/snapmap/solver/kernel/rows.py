"""The rows of the work array X; what each is stands in docs/theory.md, section "Symbols".

All state and coefficients of the cells in flight stand in one flat array, row r of lane l at
X[r * LANES + l]: only so does the compiler see that rows never alias, and vectorises over lanes.
Times are counted in steps, forces are times dt^2. Modules import this one as R.
"""

from ...numerics.kept_kernels import inlined

LANES = 16

# Rows of one number: the device's; the cell's; scratch; from STATE on, the state at instant n.
AXIAL, RESIDUAL, CONTACT, MASS, SPRING, TARGET, BARRIER, SADDLE = range(8)
GAP, BEAM_DAMPING, STOP_TOWARD, STOP_AWAY, RESTITUTION = range(8, 13)
AMPLITUDE, KEEP, MOBILITY, BEAM_KEEP, BEAM_MOBILITY = range(13, 18)
X_STEP, PIECE = 18, 19
BEGIN, START, SLOPE, TURNS, LIFT, SWING, TURN, PULSE, PULSE_STEP, PULSE_LEFT = range(19, 29)
HALF_CONTACT, TENSION, SOFTENING, COMPLIANCE = range(29, 33)
SHOCK, W_FREE, Y_FREE, OVERLAP_FREE, OVERLAP_GIVE = range(33, 38)
STRETCH_FREE, INVERSE, ALONG, FORCE, SWITCHES = range(38, 43)
LAST_SWING, SINCE, BEYOND_SINCE, WORST = range(43, 47)
STATE = 47
Y, Y_STEP, STRETCH, OVERLAP = range(47, 51)
W_BEFORE, W, COUNT, WORK, GROSS_WORK, SWEPT, BEAM_SWEPT, BEYOND, LOST = range(51, 60)
# Vectors of k rows, from row VECTORS on: the state; scratch; the device's; S, k vectors.
VECTORS = 60
P, P_STEP, SCRATCH, FREE, STIFFNESS, SLOPE_START, LOAD, MIDPOINT, GEOMETRIC = range(9)


@inlined
def row(name, l):
    """Place in X of a row of one number, lane l."""
    return name * LANES + l


@inlined
def at(vector, i, modes, l):
    """Place in X of component i of a vector, lane l."""
    return (VECTORS + vector * modes + i) * LANES + l
