"""Learning: histograms of settled spheres, classifiers of functions, and models on disk (paper, §III-B and §III-C).

May import `settling` and what lies below it; the models that ship lie in `models/`.
"""
