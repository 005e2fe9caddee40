"""Compare: the paper's experiments, comparisons of simulators, figures, benchmarks and the demo.

May import `scenes` and the shared stack; simulators come through the registry, never by import.
"""
