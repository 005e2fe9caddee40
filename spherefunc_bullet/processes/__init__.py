"""Processes: tasks done in workers that may die, and the memory of a process.

May import only the words of the package's root (`errors`, `console`); what a task does is not its business.
"""
