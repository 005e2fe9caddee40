"""Commands of the shared stack: ``spherefunc X`` is ``X.py``, found through the entry points ``spherefunc.commands``.

May import everything in `spherefunc_bullet`, and is imported by nothing but other packages' commands, for `options`.
"""
