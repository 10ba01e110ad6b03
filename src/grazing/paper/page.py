"""The contact sheet: one page with all figures, the windows of the flow, the claims and the slips."""

from __future__ import annotations

from html import escape
from typing import Any

from grazing.paper.drawn import BESIDE, module_of
from grazing.paper.run import Run
from grazing.paper.slips import SLIPS
from grazing.plot.style import software

STYLE = """
body { font: 15px/1.45 Georgia, serif; color: #1a1a1a; margin: 0 auto; max-width: 78rem; padding: 1.5rem; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; } h2 { margin-top: 2.2rem; border-bottom: 1px solid #bbb; }
.sheet { display: grid; grid-template-columns: repeat(auto-fill, minmax(24rem, 1fr)); gap: 1.6rem; }
.wide { grid-column: 1 / -1; } .pair { display: grid; grid-template-columns: 1fr 1fr; gap: 1rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; } figcaption { font-size: 0.9rem; }
figcaption b { font-size: 1rem; } .see { color: #333; } .parameters { color: #555; font-size: 0.82rem; }
table { border-collapse: collapse; font-size: 0.84rem; width: 100%; } th { text-align: left; }
th, td { border-bottom: 1px solid #ddd; padding: 0.25rem 0.5rem; vertical-align: top; overflow-wrap: anywhere; }
td.number { font-variant-numeric: tabular-nums; text-align: right; white-space: nowrap; }
.agrees { background: #dff0e0; } .corrected { background: #fdeec5; } 
.differs { background: #f7d0cc; font-weight: bold; } .none { background: #eee; }
.verdict { border-radius: 0.2rem; padding: 0 0.35rem; white-space: nowrap; }
@media (max-width: 50rem) { .pair { grid-template-columns: 1fr; } }
@media print { figure, tr { break-inside: avoid; } }
"""

#: Each verdict in a sentence, for one claim and for any other number.
VERBS = {"agrees": ("agrees", "agree"), "corrected": ("corrected", "corrected"), "differs": ("differs", "differ")}
NO_CLAIMS = "no claims belong to these figures"


def page(names: tuple[str, ...], records: list[dict[str, Any]], run: Run, size: str, beside: bool) -> str:
    """Return the contact sheet as a page of HTML that needs nothing but the figures beside it.

    Parameters
    ----------
    names : tuple of str
        Figures drawn.
    records : list of dict
        The claims as in ``claims.json``.
    run : Run
        For the table of windows.
    size : str
    beside : bool
        Whether the comparison of Figures 1.6 and 3.2 was drawn.
    """
    sheet = "\n".join(shown(name, wide=name in ("1.3", "1.6", "3.2", "3.3", "3.5", "3.7")) for name in names)
    slips = "".join(f'<li id="slip-{n}">{escape(text)}</li>' for n, text in SLIPS.items())
    parts = [
        f"<p>{summary(names, records)} Size: {escape(size)}. Made by {escape(software())}.</p>",
        f'<h2>Figures</h2><div class="sheet">{sheet}</div>',
        compared() if beside else "",
        window_table(run) if "1.6" in names else "",
        f"<h2>Claims</h2>{claim_table(records)}",
        f"<h2>Where the paper is wrong or loose</h2><ol>{slips}</ol>",
    ]
    title = "The dynamics of a simplified pin-ball machine, computed anew"
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
        "<p>Pring and Budd, IMA Journal of Applied Mathematics 76 (2011) 67–84.</p>\n"
        + "\n".join(part for part in parts if part)
        + "\n</body>\n</html>\n"
    )


def summary(names: tuple[str, ...], records: list[dict[str, Any]]) -> str:
    """Return one sentence on what was computed."""
    from grazing.paper import FIGURES

    counts = {verdict: sum(r["verdict"] == verdict for r in records) for verdict in ("agrees", "corrected", "differs")}
    said = ", ".join(
        f'<span class="verdict {verdict if n else "none"}">{n} {VERBS[verdict][n != 1]}</span>'
        for verdict, n in counts.items()
    )
    with_claims = ", with their claims" if records else ""
    part = "" if names == FIGURES else f" This is a selection: {len(names)} of {len(FIGURES)} figures{with_claims}."
    if not records:
        return f"{NO_CLAIMS[0].upper()}{NO_CLAIMS[1:]}.{part}"
    number = "1 claim" if len(records) == 1 else f"{len(records)} claims, each"
    return f"{number} computed in this run: {said}.{part}"


def image(name: str) -> str:
    """Return the image of a figure, linked to its file for print."""
    file = f"figure-{name}"
    return f'<a href="{file}.pdf"><img src="{file}.png" alt="Figure {escape(name)}" loading="lazy"></a>'


def shown(name: str, wide: bool = False) -> str:
    """Return a figure with its caption, parameters and what must be seen."""
    module = module_of(name)
    values = ", ".join(f"{escape(key)} = {escape(str(value))}" for key, value in module.PARAMETERS.items())
    return (
        f'<figure id="figure-{name}" class="{"wide" if wide else "plain"}">{image(name)}<figcaption>'
        f"<b>{escape(name)} {escape(module.TITLE)}.</b> {escape(module.CAPTION)} "
        f'<span class="see"><i>What to see:</i> {escape(module.SEE)}</span><br>'
        f'<span class="parameters">{values} · <a href="figure-{name}.pdf">PDF</a></span></figcaption></figure>'
    )


def compared() -> str:
    """Return Figures 1.6 and 3.2 side by side, and on one axis."""
    module = module_of(BESIDE)
    pair = "".join(f"<figure>{image(name)}<figcaption>Figure {name}</figcaption></figure>" for name in ("1.6", "3.2"))
    return (
        f'<h2>Figures 1.6 and 3.2 side by side</h2><div class="pair">{pair}</div>'
        "<p>μ grows as d falls, so that one is the mirror image of the other.</p>"
        f"<figure>{image(BESIDE)}<figcaption><b>{escape(module.TITLE)}.</b> {escape(module.CAPTION)} "
        f'<span class="see"><i>What to see:</i> {escape(module.SEE)}</span></figcaption></figure>'
    )


def window_table(run: Run) -> str:
    """Return the exact windows of the flow beside those of the normal form, with errors."""
    from grazing.paper.claims_flow_windows import table

    def cell(value: float | None, form: str) -> str:
        return f'<td class="number">{"–" if value is None else format(value, form)}</td>'

    rows = "".join(
        f'<tr><td class="number">{row["N"]}</td>'
        + "".join(
            cell(row["exact"][i], ".15f") + cell(row["predicted"][i], ".12f") + cell(row["error"][i], "+.2e")
            for i in (0, 1)
        )
        + "</tr>"
        for row in table(run)
    )
    return (
        "<h2>Windows of the oscillator and of its normal form</h2>"
        "<p>Edges in d of the stable orbits with one impact in N periods, S with V = 0.4. Lower edge: the last "
        "dip before the impact grazes, in the normal form the border collision. Upper edge: period doubling.</p>"
        "<table><tr><th>N</th><th>lower edge, exact</th><th>normal form</th><th>error</th>"
        f"<th>upper edge, exact</th><th>normal form</th><th>error</th></tr>{rows}</table>"
    )


def claim_table(records: list[dict[str, Any]]) -> str:
    """Return all claims with their verdicts."""
    if not records:
        return f"<p>{NO_CLAIMS[0].upper()}{NO_CLAIMS[1:]}.</p>"
    rows = "".join(
        f'<tr><td><span class="verdict {r["verdict"]}">{r["verdict"]}</span>{slip(r)}</td><td>{escape(r["where"])}</td>'
        f"<td>{escape(r['claim'])}</td><td>{value(r['claimed'])}</td><td>{value(r['computed'])}</td>"
        f'<td class="number">{value(r["tolerance"])}</td><td>{escape(r["note"])}</td></tr>'
        for r in records
    )
    head = (
        "<th>verdict</th><th>where</th><th>claim</th><th>claimed</th><th>computed</th><th>tolerance</th><th>note</th>"
    )
    return f"<table><tr>{head}</tr>{rows}</table>"


def slip(record: dict[str, Any]) -> str:
    """Return the link from a corrected claim to the list of slips."""
    return f' <a href="#slip-{record["slip"]}">{record["slip"]}</a>' if record["slip"] else ""


def value(item: Any) -> str:
    """Return a claimed or computed value as text."""
    if isinstance(item, bool):
        return "yes" if item else "no"
    if isinstance(item, float):
        return f"{item:.12g}"
    if isinstance(item, list):
        return escape(", ".join(value(each) for each in item)) if item else "none"
    return escape(str(item)) if item != "" else "none"
