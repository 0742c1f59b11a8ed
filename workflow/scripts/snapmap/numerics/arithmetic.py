"""What kernels share beyond numpy: fused multiply-adds, a sine, and the width of vectors.

Each is the same on every machine. numba's cache of a kernel does not see an edit here.
"""

import numpy as np
from numba import float64, njit, types
from numba.extending import intrinsic

from . import portable

VECTOR_BITS = 512
"""Widest vectors to use where the processor has them."""


@intrinsic
def fma(context, a, b, c):
    """a b + c in one rounding."""

    def build(_, builder, __, arguments):
        return builder.fma(*arguments)

    return float64(float64, float64, float64), build


@intrinsic
def widen_vectors(context):
    """Compile the function that calls this with vectors of VECTOR_BITS, and by itself.

    LLVM stops at 256 bits on some processors that have 512, and the kernel then takes up to twice
    the time. numba's own settings would reach the functions of whoever imports this, too. A loop
    over lanes may lose its vectors where LLVM puts it into its caller.
    """

    def build(context, builder, _, __):
        attribute = f'"prefer-vector-width"="{VECTOR_BITS}"'
        set.add(builder.function.attributes, attribute)  # llvmlite's own `add` knows few of LLVM's
        builder.function.attributes.add("noinline")
        return context.get_dummy_value()

    return types.none(), build


_sine_of_rest = njit(error_model="numpy", inline="always")(portable.sine_of_rest)


@njit(error_model="numpy", inline="always")
def sine(turns):
    """As `portable.sine`, in a form of which the compiler makes vectors."""
    return _sine_of_rest(turns - np.rint(turns))
