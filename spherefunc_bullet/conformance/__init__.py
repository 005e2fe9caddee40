"""What every backend must keep, as tests that another package can run.

``pytest --pyargs spherefunc_bullet.conformance --backend NAME``, see docs/backends.md. Needs pytest, which
the extra ``conformance`` brings. May import the interface and clouds.
"""
