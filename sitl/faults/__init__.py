"""What can go wrong with a simulated vehicle, when, and what follows for the parts that it concerns."""
