"""Independent oracles: closed forms, SciPy DOP853 at 1e-12, float64 NumPy.

Nothing here imports `cpm`, and nothing here was derived from its source.  Each module says
which equation of DESIGN.md (or of the literature) it states; `analytic/test_oracles.py`
checks the modules against each other.
"""
