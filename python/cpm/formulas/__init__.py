"""Formulas of ``cpm.media.Expression``: text → tree (grammar) → SymPy (symbolic) → program (program).

Text is parsed by a grammar of our own and never evaluated as code. Sizes are bounded at every stage, so that no text, however
hostile, costs more than a moment.
"""
from .program import Program, compile_formula

__all__ = ["Program", "compile_formula"]
