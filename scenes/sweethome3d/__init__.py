"""Sweet Home 3D: the furniture libraries of that program as labelled data sets.

May import only the shared stack; `functions.csv` says what each kind of furniture is for.
"""
