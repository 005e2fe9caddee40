"""Where objects come from: catalogues, libraries of furniture, rooms and depth sensors."""
