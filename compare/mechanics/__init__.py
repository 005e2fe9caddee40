"""Tasks with known answers for which rigid bodies tell more than geometry: poses, standing, keeping, places to sit."""
