"""The models that ship with the package, made by ``make model`` and ``make scan-model``."""
