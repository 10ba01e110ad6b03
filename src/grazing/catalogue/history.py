"""Position or velocity over time, as they are asked for and told."""

from __future__ import annotations

from grazing.catalogue import trajectory
from grazing.catalogue.study import Study

STUDY = Study(
    name="history", place=80, compute="grazing.signals.record:history", of="model",
    says="position or velocity of one orbit over time",
    help="Show position or velocity over time, with every impact.",
    example="u=0 v=0 --until 20 --d 0.12 --V 0.4 -o history.png",
    prints="the number of impacts and the first five, chatter, rests on the wall, whether it is certified",
    found=trajectory.found, words=trajectory.words, sounds=True,
)  # fmt: skip
