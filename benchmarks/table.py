"""Print tables: drawn in a terminal, Markdown everywhere else, so that they can be pasted into a page."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

Lines = Sequence[Sequence[str]]


def show(out: Console, title: str, head: Sequence[str], lines: Lines, left: int = 1) -> None:
    """Print one table; all but the first ``left`` columns are flush right."""
    if out.is_terminal:
        table = Table(title=title, title_justify="left", box=box.ROUNDED)
        for i, name in enumerate(head):
            table.add_column(name, justify="left" if i < left else "right", overflow="fold")
        for line in lines:
            table.add_row(*line)
        out.print(table)
    else:
        rule = ["---" if i < left else "---:" for i in range(len(head))]
        rows = "\n".join(f"| {' | '.join(line)} |" for line in (head, rule, *lines))
        out.file.write(f"\n{title}\n\n{rows}\n")
