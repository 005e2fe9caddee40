"""Sweet Home 3D: the furniture libraries of that program as labelled data sets.

May import the shared stack, and `household.parts` to stand objects on the ground; `functions.csv` says what each kind
of furniture is for.
"""
