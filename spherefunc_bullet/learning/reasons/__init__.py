"""Evidence for and against a function by cubes of space."""
