"""Processes: tasks done in workers that may die, the memory of a process, and kernels compiled once for all of them.

May import only the words of the package's root (`errors`, `console`); what a task does is not its business.
"""
