"""How real scans are scored: what is found, and what is counted apart."""

from __future__ import annotations
