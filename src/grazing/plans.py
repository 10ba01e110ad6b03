"""Plans of studies: what a sweep runs, made from the arguments of the study, without its threads and progress."""

from grazing.studies.basins import plan as basins
from grazing.studies.chart import plan as chart
from grazing.studies.coexistence import plan as coexistence
from grazing.studies.density import plan as density
from grazing.studies.lyapunov import plan as lyapunov
from grazing.studies.orbit_diagram import plan as orbit_diagram
from grazing.studies.portrait import plan as portrait
from grazing.studies.word_statistics import plan as word_statistics

__all__ = ["basins", "chart", "coexistence", "density", "lyapunov", "orbit_diagram", "portrait", "word_statistics"]
