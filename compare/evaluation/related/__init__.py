"""Related work as baselines (paper, §II): rules on measures, and agents that try an object. Neither learns anything.

May import the evaluation's labels and splits and the records of objects; the tables import it.
"""
