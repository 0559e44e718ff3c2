"""What differs between autopilots: modes, arming, taking over, refusals."""
