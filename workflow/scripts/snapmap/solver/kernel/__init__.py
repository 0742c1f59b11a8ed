"""The kernels of all modal models: an energy-conserving scheme with a cell in each SIMD lane.

Lanes have separate coefficients, so that cells of different devices share a call, and no result
depends on other lanes. A function is compiled for k modes by its argument `shape`, a tuple of k
numbers, as the compiler knows the length of a tuple.
"""
