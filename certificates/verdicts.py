"""What a check may end with."""


class Malformed(Exception):
    """The file is not a certificate: a rule of the format is broken."""


class NotProved(Exception):
    """The file is a certificate, but something it claims does not follow."""
