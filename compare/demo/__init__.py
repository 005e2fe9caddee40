"""Demo: all steps on the built-in catalogue, and the pictures of the documents.

May import `evaluation`, `comparison` and `pages`; nothing imports it.
"""
