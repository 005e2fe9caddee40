"""Why an object is said to have a function or not: by quantities, in words, or by cubes of space."""
