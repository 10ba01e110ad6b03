"""Sweeps: a study of any size, computed in chunks into a Zarr store, stopped and resumed at will.

A store is a folder. All of its arrays are created first, whole or not at all; then a task computes one chunk of
cells, writes it, and last its cell of ``done``. Chunks are files that get their names when they are complete, so that
no process that is killed leaves a damaged one. See ``docs/sweeps.md``.
"""

from grazing.sweep.cluster import cluster as cluster
from grazing.sweep.estimate import Estimate as Estimate
from grazing.sweep.estimate import estimate as estimate
from grazing.sweep.lock import Lock as Lock
from grazing.sweep.lock import unlock as unlock
from grazing.sweep.reading import open_store as open_store
from grazing.sweep.run import resume as resume
from grazing.sweep.run import run as run
from grazing.sweep.status import Status as Status
from grazing.sweep.status import status as status
from grazing.sweep.verify import Difference as Difference
from grazing.sweep.verify import Verified as Verified
from grazing.sweep.verify import verify as verify
