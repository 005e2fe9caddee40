"""Pages: HTML, plates and pictures of the reports and figures.

May import only the shared stack; knows no experiment.
"""
