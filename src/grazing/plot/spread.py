"""Names beside markers, where they cover nothing."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.transforms import Bbox

from grazing.plot.style import root

#: Size of a marker in points.
MARKER = 4.2


def laid_out(ax: Axes, whole: bool = True) -> Any:
    """Put axes where they will be drawn, if the whole figure is to be laid out; return what measures texts there."""
    figure = root(ax)
    ax.get_xlim()  # limits that wait to be found: before, every point lies outside and every name on the others
    canvas = figure.canvas
    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    if whole and (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
    figure.set_canvas(canvas)
    return renderer


def spread(ax: Axes, texts: list[Any], markers: list[Any]) -> None:
    """Move names that would cover each other or a marker to the first place that is free; where none is, leave it out.

    Called when everything else is there: a legend beside the axes makes them narrower.
    """
    places = [(3, 3), (3, -8), (-11, 3), (-11, -8), (-4, 6), (-4, -12), (3, 10), (3, -15), (-11, 10), (-11, -15)]
    renderer = laid_out(ax, bool(texts))
    radius = 0.5 * MARKER * root(ax).dpi / 72.0
    corners = [ax.transData.transform(artist.get_xydata()[0]) for artist in markers]
    taken: list[Any] = [Bbox([at - radius, at + radius]) for at in corners]
    inside = ax.get_window_extent(renderer).padded(radius)
    for text in texts:
        text.set_visible(True)
        for place in places:
            text.set_position(place)
            box = text.get_window_extent(renderer)
            if inside.containsx(box.x1) and not any(box.overlaps(other) for other in taken):
                taken.append(box)
                break
        else:
            text.set_visible(False)
