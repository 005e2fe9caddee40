"""Commands of the shared stack: ``spherefunc X`` is ``X.py``, found through the entry points ``spherefunc.commands``.

May import everything in `spherefunc_bullet`; only commands of other packages import it, for `options`.
"""
