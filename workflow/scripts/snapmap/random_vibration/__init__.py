"""Random vibration: records of a spectrum, and how likely they trip a device."""
