"""The kernels of every modal model: differences that conserve energy, one cell per SIMD lane.

Each lane has coefficients of its own, so cells of different devices share a call, and no lane's
result depends on its neighbours. A function compiled for k modes gets them as `shape`, a tuple of k
numbers, whose length the compiler knows.
"""
