"""Draw the colours of the periods, docs/figures/colours.png: python docs/make_colours.py."""

from pathlib import Path

from matplotlib.patches import Rectangle

import grazing as gz
from grazing.plot.classes import NAMES
from grazing.plot.style import PERIODS, ink_on


def main() -> Path:
    """Draw one box for each colour, those of classes without a period in a row below."""
    fig, (ax,) = gz.plot.panels(width=174, height=26)
    boxes = [(float(k % 8), -float(k // 8), gz.plot.period_colour(k + 1), f"{k + 1}") for k in range(len(PERIODS))]
    boxes += [(8.4, 0.32 - k * 0.66, gz.plot.period_colour(code), name) for k, (code, name) in enumerate(NAMES.items())]
    with gz.plot.styled():
        for x, y, colour, name in boxes:
            wide, high = (2.0, 0.58) if x > 8 else (0.94, 0.9)
            ax.add_patch(Rectangle((x, y), wide, high, facecolor=colour, lw=0))
            ax.text(x + wide / 2, y + high / 2, name, color=ink_on(colour), ha="center", va="center", fontsize=9)
    ax.set_xlim(0, 10.4)
    ax.set_ylim(-1.1, 1.0)
    ax.set_axis_off()
    return gz.plot.save(fig, Path(__file__).parent / "figures" / "colours.png", "The colours of the periods")


if __name__ == "__main__":
    print(main())
