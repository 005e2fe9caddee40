"""Viewer: objects, settled spheres and cubes as interactive pages, and why a function was classified.

May import `learning` and what lies below it; needs neither network nor libraries in the browser.
"""
