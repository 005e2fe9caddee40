"""Processes: tasks in worker processes that may die, and kernels compiled once for all processes.

May import only the modules of the package's root (`errors`, `console`); it does not depend on the tasks.
"""
