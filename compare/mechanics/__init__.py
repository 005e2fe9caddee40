"""What rigid bodies tell and geometry cannot: poses, standing and keeping, each as a task with known answers."""
