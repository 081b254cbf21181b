"""Delta robots: poses for given drives, drives for a given pose, kinematics and singularities."""
