"""What a function of this package drew: its artists by name, and in a notebook the figure."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import signature
from io import BytesIO
from typing import Any, TypeVar

from matplotlib.figure import Figure

from grazing.measured import measured
from grazing.plot.options import bound

Draw = TypeVar("Draw", bound=Callable[..., Any])

#: Dots per inch on a screen.
SCREEN = 144
#: What is drawn over other figures of this package, and goes on with their legends.
OVER = ("branch", "grazes", "manifolds")


def png_of(figure: Figure) -> bytes | None:
    """Return a figure as a notebook shows it; None for one of pyplot, which shows it itself."""
    if getattr(figure.canvas, "manager", None) is not None:
        return None
    with BytesIO() as file:
        figure.savefig(file, format="png", dpi=SCREEN, bbox_inches=None, metadata={"Software": None})
        return file.getvalue()


class Inline(Figure):
    """A figure that a notebook shows, although it belongs to no window."""

    def _repr_png_(self) -> bytes | None:
        return png_of(self)


class Drawn(dict[str, Any]):
    """Artists by name, with the figure under ``"figure"``, which a notebook shows where this is the last line.

    Examples
    --------
    >>> import grazing as gz
    >>> motion = gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=20.0)
    >>> gz.plot.trajectory(motion)
    <Drawn: figure, flights, impacts, strobe, wall>
    """

    def __repr__(self) -> str:
        return f"<Drawn: {', '.join(self)}>"

    def _repr_png_(self) -> bytes | None:
        figure = self.get("figure")
        return png_of(figure) if isinstance(figure, Figure) else None


def inline(draw: Draw) -> Draw:
    """Let a function that returns a dict of artists return it as :class:`Drawn`, and draw a rig as it is measured.

    Its options are checked before, see :mod:`grazing.plot.options`.

    A ``legend`` that may be None is one in a figure of its own only: axes that are given have what their owner puts
    there. Branches and manifolds go on with a legend that is there.
    """
    call = signature(draw)
    chosen = call.parameters.get("legend")
    alone = chosen is not None and chosen.default is None

    @wraps(draw)
    def shown(*args: Any, **more: Any) -> Drawn:
        args, more = bound(call, args, more)
        if args:
            args = (measured(args[0]), *args[1:])
        elif "result" in more:
            more["result"] = measured(more["result"])
        if alone and more.get("legend") is None:
            ax = args[1] if len(args) > 1 else more.get("ax")
            more["legend"] = ax is None or (draw.__name__ in OVER and ax.get_legend() is not None)
        return Drawn(draw(*args, **more))

    return shown  # type: ignore[return-value]
