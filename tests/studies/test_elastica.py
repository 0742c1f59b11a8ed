"""The exact beam comes down to the shallow one as its rise does."""

from dataclasses import replace

import numpy as np

from snapmap import statics
from studies.elastica import corners


def test_the_shallow_beam_errs_by_the_square_of_rise_over_span(handout):
    def apart(scale):
        beam = handout.beam
        beam = replace(beam, rise=beam.rise * scale, thickness=beam.thickness * scale)
        path = statics(replace(handout, beam=beam))
        (near, largest), (far, least) = corners(beam)
        exact = np.array([near, largest, far, least])
        force, place = path.force.values[0], path.displacement.values[0] / beam.rise
        ends = (force.argmax(), force.argmin())
        ours = [(place[at], force[at]) for at in ends]
        return np.ravel(ours) / exact - 1

    np.testing.assert_allclose(apart(2.0) / apart(1.0), 4.0, rtol=0.1)
