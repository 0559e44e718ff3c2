"""Plans: missions, fences and rally points, and the flight by them; what PX4 and ArduPilot have in common."""
