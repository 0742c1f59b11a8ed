"""The beam, in internal units: um, ng, us, and hence uN, MPa and pJ.

Each value is a number, or an array, (devices,), for a batch of devices.
"""

import math
from dataclasses import fields
from functools import cached_property
from typing import Annotated

import numpy as np

from ..values import quantities
from ..values.kinds import Fitting, Number
from ..values.records import record
from ..values.units import plain_numbers
from .arch import Equilibria, equilibria, least_residual
from .shape import BISTABILITY_LIMIT, TERMS, TILT, coefficients, midpoint, modes_of
from .usual import require

THINNEST = 1e6
"""Largest rise over thickness: beyond it a float cannot hold bending beside stretch."""
FLAT = 1e-8
"""Rise of a straight beam over its buckled rise: it makes one of two equal shapes the first."""


def _floats(value):
    """Convert true or false, or 1 and 0, to floats; None for others."""
    array = np.asarray(value) if isinstance(value, bool | np.bool_) else plain_numbers(value)
    if array is None or not np.isin(array, (0, 1)).all():
        return None
    return array.astype(float) if array.ndim else float(array)


def _is_flag(value):
    return _floats(value) is not None


_FLAG = Fitting("True or False", _is_flag, _floats, "true or false", {"type": "boolean"}, bool)
Free = Annotated[bool, _FLAG]
"""True or false, or a batch of these, held as floats 1 and 0."""


@record
class Beam:
    """Dimensions and material of a clamped beam; an impossible value raises ValueError.

    A plain number counts in um, MPa, ng/um^3 and 1/us; text has its unit, as "150 GPa".

    Examples
    --------
    >>> snapmap.load_device("config/config.yaml").beam.rise
    10.0
    """

    span: quantities.Length
    """distance between the clamps"""
    rise: quantities.Distance
    """height of the midpoint as made; a straight beam, which compression must buckle, has 0"""
    thickness: quantities.Length
    """thickness in the direction of motion"""
    depth: quantities.Length
    """width across the plane of motion; of a double beam, of both beams together"""
    youngs_modulus: quantities.Modulus
    """Young's modulus"""
    density: quantities.Density
    """density of the beam"""
    damping: quantities.Rate = 0.0
    """viscous drag per unit mass; oscillations decay at half this rate"""
    residual_stress: quantities.Stress = 0.0
    """axial stress before the beam bends; tension is positive"""
    imperfection: quantities.Distance = 0.0
    """amplitude of the first antisymmetric shape as made; a free beam needs one above 0"""
    free: Free = 0.0
    """whether the beam can tilt; a guided beam cannot"""
    clamp_axial: quantities.Clamp = math.inf
    """stiffness of each clamp along the beam; rigid if left out"""
    cosine_2: quantities.Part = 0.0
    """amplitude of (1 - cos(2 n pi x/L))/2 in the shape as made, over the rise; the name has n"""
    cosine_3: quantities.Part = 0.0
    """amplitude of (1 - cos(2 n pi x/L))/2 in the shape as made, over the rise; the name has n"""
    cosine_4: quantities.Part = 0.0
    """amplitude of (1 - cos(2 n pi x/L))/2 in the shape as made, over the rise; the name has n"""
    cosine_5: quantities.Part = 0.0
    """amplitude of (1 - cos(2 n pi x/L))/2 in the shape as made, over the rise; the name has n"""

    def __post_init__(self):
        """Raise ValueError for values that do not fit each other."""
        tilt = self.imperfection
        guided, perfect = np.equal(self.free, 0), np.equal(tilt, 0)
        lacks = "imperfection: {:g} um never tilts a free beam; write one such as 0.01 um"
        require(guided | ~perfect, lacks, tilt)
        tilts = "imperfection: {:g} um needs a beam free to tilt; write free: true"
        require(perfect | ~guided, tilts, tilt)
        steep = "imperfection: {:g} um is more than a tenth of the span; write less"
        require(np.less_equal(tilt, np.divide(self.span, 10)), steep, tilt)
        Q = np.divide(self.rise, self.thickness)
        thin = "thickness: {:g} um gives Q = rise/thickness = {:.6g}; write one that gives Q up to "
        require(np.less_equal(Q, THINNEST), f"{thin}{THINNEST:g}", self.thickness, Q)

    def require_second_shape(self) -> None:
        """Raise ValueError if the beam, or one of a batch, has no second stable shape."""
        if not np.all(self.is_bistable):
            require(
                self.is_bistable,
                "device.beam: no second stable shape with rise/thickness = {:g} um/{:g} um = "
                "{:.6g} and a stress of {:g} MPa; write a stress below {:.5g} MPa or, for a cosine "
                "without stress, rise/thickness above {:.3f}",
                *(self.rise, self.thickness, np.divide(self.rise, self.thickness)),
                *(self.residual_stress, self.most_stress, BISTABILITY_LIMIT / np.sqrt(self.held)),
            )

    @property
    def area(self) -> Number:
        """A = depth thickness, um^2."""
        return self.depth * self.thickness

    @property
    def inertia(self) -> Number:
        """I = depth thickness^3 / 12, um^4."""
        return self.area * self.thickness * self.thickness / 12

    @property
    def mass_per_length(self) -> Number:
        """rho A, ng/um."""
        return self.density * self.area

    @property
    def bending_stiffness(self) -> Number:
        """E I, uN um^2."""
        return self.youngs_modulus * self.inertia

    @property
    def axial_stiffness(self) -> Number:
        """E A / (2 span) times `held`, uN/um: axial force per integral of w'^2."""
        return self.youngs_modulus * self.area / (2 * self.span) * self.held

    @property
    def held(self) -> Number:
        """Axial stiffness of beam and clamps in series over that of the beam, at most 1."""
        return 1 / (1 + 2 * self.youngs_modulus * self.area / (self.clamp_axial * self.span))

    @property
    def weight(self) -> Number:
        """rho A span, the beam's mass, ng."""
        return self.mass_per_length * self.span

    @property
    def stiffness_unit(self) -> Number:
        """E I / span^3, uN/um."""
        return self.bending_stiffness / (self.span * self.span * self.span)

    @property
    def made_rise(self) -> Number:
        """The rise, um, that scales shapes; a straight beam has FLAT times its buckled rise."""
        if np.all(self.rise):
            return self.rise
        beyond = np.maximum(self.compression - 1, FLAT)
        buckled = self.thickness * np.sqrt(4 / 3 * beyond / self.held)
        return np.where(np.equal(self.rise, 0), FLAT * buckled, self.rise)[()]

    @property
    def bistability(self) -> Number:
        """Q = rise / thickness, times sqrt(`held`) for clamps of finite stiffness."""
        return self.made_rise / self.thickness * np.sqrt(self.held)

    @property
    def cosines(self) -> np.ndarray:
        """Coefficients a_n of the shape as made, (..., TERMS), as in `shape.coefficients`."""
        return coefficients([getattr(self, name) for name in COSINES])

    @property
    def is_cosine(self) -> np.ndarray:
        """Whether the shape as made is the first cosine alone, as an array."""
        plain = [np.equal(getattr(self, name), 0) for name in COSINES]
        return np.logical_and.reduce(np.broadcast_arrays(*plain))

    @cached_property
    def at_rest(self) -> Equilibria:
        """Equilibria of the guided beam, in units of the rise and the first buckling load."""
        shape, arch, compression = self._arch
        parts = equilibria(*arch, compression)
        return Equilibria(*(part.reshape(shape + part.shape[1:]) for part in parts))

    @property
    def _arch(self):
        """Shape of the batch; loads, s and EA/2L, as `modes_of` returns them; compression."""
        Q, compression, _ = np.broadcast_arrays(self.bistability, self.compression, self.is_cosine)
        a = np.broadcast_to(self.cosines, (*Q.shape, TERMS))
        return Q.shape, modes_of(Q.ravel(), a.reshape(-1, TERMS)), compression.ravel()

    @property
    def is_bistable(self) -> bool | np.ndarray:
        """Whether the guided beam has a second stable shape."""
        return np.isfinite(self.at_rest.N_second)[()]

    @property
    def bending_frequency(self) -> Number:
        """First frequency of a straight clamped beam, (4.7300/L)^2 sqrt(EI / rho A), rad/us."""
        root = 4.730040744862704 / self.span
        return root * root * np.sqrt(self.bending_stiffness / self.mass_per_length)

    @property
    def buckling_stress(self) -> Number:
        """Compression at which the flat beam buckles, 4 pi^2 EI / (A span^2), MPa."""
        root = math.pi * self.thickness / self.span
        return self.youngs_modulus * root * root / 3

    @property
    def compression(self) -> Number:
        """Residual stress over that of buckling, times `held`; compression is positive."""
        return -np.divide(self.residual_stress, self.buckling_stress) * self.held

    @property
    def most_stress(self) -> Number:
        """Residual stress, MPa, above which there is no second stable shape."""
        shape, arch, _ = self._arch
        return -least_residual(*arch).reshape(shape)[()] * self.buckling_stress / self.held

    @property
    def height(self) -> Number:
        """Midpoint of the first stable shape, um: the rise, unless there is residual stress."""
        share = midpoint(self.cosines, self.at_rest.first)
        return np.where(np.equal(self.residual_stress, 0), self.rise, self.made_rise * share)[()]

    @property
    def second_equilibrium(self) -> Number:
        """Midpoint of the second stable shape of a guided beam, um; NaN if it has none.

        For a cosine without residual stress it is -rise (1 + sqrt(1 - 16 / (3 Q^2))) / 2.
        """
        return self.made_rise * midpoint(self.cosines, self.at_rest.second)

    @property
    def stays_if_free(self) -> bool | np.ndarray:
        """Whether the second shape of a perfect beam is stable against tilting."""
        return self.at_rest.N_second < TILT


BEAM_VALUES = tuple(field.name for field in fields(Beam))
COSINES = tuple(key for key in BEAM_VALUES if key.startswith("cosine_"))
"""Names of the amplitudes of cosines 2, 3, ... of the shape as made."""
