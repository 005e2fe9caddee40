"""Compare: the paper's experiments, simulators beside each other, figures, benchmarks and the demo.

May import `scenes` and the shared stack; simulators come through the registry, never by import.
"""
