"""What rigid bodies tell and geometry cannot: poses, standing, keeping, places to sit, as tasks with known answers."""
