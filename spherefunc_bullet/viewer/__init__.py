"""Viewer: objects, settled spheres and cubes as interactive pages, and why an object was classified so.

May import `learning` and what lies below it; needs neither network nor libraries in the browser.
"""
