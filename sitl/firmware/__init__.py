"""Simulated autopilots: control laws, modes, arming and failsafes, without any MAVLink."""
