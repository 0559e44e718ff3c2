"""A simulated quadrotor that speaks MAVLink; it knows nothing of the companion."""
