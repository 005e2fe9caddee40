"""Measured tables of README and docs, each written from saved results of the command beside it."""
