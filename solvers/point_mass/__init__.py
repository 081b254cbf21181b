"""Point masses: the static pose by convexity or search, and the prepared solver of controllers."""
