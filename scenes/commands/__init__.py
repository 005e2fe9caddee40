"""Commands of the scenes: ``spherefunc X`` is ``X.py``.

May import everything in `scenes` and the shared stack; nothing imports it.
"""
