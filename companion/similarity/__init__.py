"""How alike two vehicles are, and whether what one taught serves the other: arrays in, figures out."""
