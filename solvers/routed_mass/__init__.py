"""Point masses on routed cables: over pulleys, or some elastic and others not; a class of robots."""
