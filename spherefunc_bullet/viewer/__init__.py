"""Viewer: objects, settled spheres and cubes as pages to turn about, and why a function was told.

May import `learning` and what lies below it; needs neither network nor libraries in the browser.
"""
