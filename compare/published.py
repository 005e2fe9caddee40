"""What Hinkle and Olson report (IROS 2013, Fig. 3b), to stand beside our own."""

from __future__ import annotations

PAPER = {"cup": 0.80, "sittable": 0.74, "table": 0.85}  # F-measures on its authors' own 200 models
