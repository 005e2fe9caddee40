"""Conformance tests, which every backend must pass, and which other packages can run.

``pytest --pyargs spherefunc_bullet.conformance --backend NAME``, see docs/backends.md. They need pytest, which the
extra ``conformance`` installs. May import the interface and clouds.
"""
