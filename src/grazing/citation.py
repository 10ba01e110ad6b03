"""How to cite grazing and the paper it begins with."""

from __future__ import annotations

from typing import Final

from grazing import __version__
from grazing.outcome import InputError, shown

_BIBTEX: Final = """\
@misc{{grazing,
  author = {{{{The grazing developers}}}},
  title  = {{grazing: oscillators that hit things}},
  note   = {{Python library, version {version}}}
}}

@article{{PringBudd2011,
  author  = {{Pring, S. R. and Budd, C. J.}},
  title   = {{The dynamics of a simplified pinball machine}},
  journal = {{IMA Journal of Applied Mathematics}},
  volume  = {{76}},
  number  = {{1}},
  pages   = {{67--84}},
  year    = {{2011}}
}}
"""
_TEXT: Final = """\
The grazing developers: grazing, oscillators that hit things. Python library, version {version}.
S. R. Pring and C. J. Budd: The dynamics of a simplified pinball machine. IMA Journal of Applied Mathematics 76(1), \
67-84, 2011.
"""
_STYLES: Final = {"bibtex": _BIBTEX, "text": _TEXT}


def cite(style: str = "bibtex") -> str:
    """Return the citation of this version of grazing and of the paper it begins with.

    Parameters
    ----------
    style : {"bibtex", "text"}
        BibTeX entries, or one plain line each.

    Returns
    -------
    str
        Two entries; print it.

    Raises
    ------
    InputError
        For another style.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.cite("text").splitlines()[0]
    'The grazing developers: grazing, oscillators that hit things. Python library, version ...'
    """
    if not isinstance(style, str) or style not in _STYLES:
        raise InputError(f"style is {shown(style)}; allowed are {' and '.join(repr(name) for name in _STYLES)}")
    return _STYLES[style].format(version=__version__)
