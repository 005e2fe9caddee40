"""Measured tables of README and docs, each written from the saved results of the command below it."""
