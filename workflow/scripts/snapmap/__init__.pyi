from .applications.calibration.dataset import calibrate as calibrate
from .applications.design.design import design as design
from .applications.histories.history import simulate as simulate
from .applications.spectra.trips import srs_test as srs_test
from .applications.spectra.vibration import vibration as vibration
from .applications.statics.statics import statics as statics
from .applications.tolerances.dataset import tolerance as tolerance
from .config.devices import load_device as load_device
from .device.curved_beam import Beam as Beam
from .device.device import Device as Device
from .figures.maps import plot_outcome as plot_outcome
from .pulse.pulse import Pulse as Pulse
from .pulse.pulse import read_pulse as read_pulse
from .pulse.pulse import sampled as sampled
from .solver.options import Auto as Auto
from .solver.options import Cosines as Cosines
from .solver.options import Elements as Elements
from .solver.options import Reference as Reference
from .study.study import Study as Study
from .study.variables import words as words
from .sweeps.cube import open_cube as open_cube
from .sweeps.cube import sweep as sweep
from .thresholds.surface import threshold as threshold

__version__: str
