"""Pages: HTML, plates and pictures that the reports and figures are made of.

May import only the shared stack; knows no experiment.
"""
