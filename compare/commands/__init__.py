"""Commands of the experiments: ``spherefunc X`` is ``X.py``.

May import everything in `compare`; nothing imports it.
"""
