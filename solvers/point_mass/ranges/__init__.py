"""Point masses whose data are ranges: the one pose of every choice, in sharp bounds."""
