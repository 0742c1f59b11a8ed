"""Files that are whole or absent, tables, and text that is safe in messages and tables."""

import os

# Files are replaced, and never written where others read: HDF5 needs no locks, which some file
# systems refuse. It reads this when netCDF4 is imported.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
