"""The paper, figure by figure and claim by claim, computed anew: ``grazing.paper.report.report()``."""

__all__ = ["FIGURES"]

#: The figures of the paper that show a result, in its order; 1.1 and 1.4 are photographs.
FIGURES = ("1.2", "1.3", "1.5", "1.6", "2.1", "2.2", "3.1", "3.2", "3.3", "3.4", "3.5", "3.6", "3.7")
