"""Point masses whose cables run over pulleys, or of which some stretch and others do not."""
