"""What rigid bodies tell and geometry cannot: poses, standing, keeping, as tasks with known answers."""
