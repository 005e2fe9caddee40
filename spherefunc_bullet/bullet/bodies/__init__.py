"""Bodies that are free to move: how an object falls and stands by itself, and what it keeps when it is carried."""
