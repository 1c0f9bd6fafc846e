"""`gecos doctor`: finds what keeps programs from meeting, and says what mends it.

Each module has checks of one kind, as functions of values that are read elsewhere: `readings` reads
them, and `examination` puts both together.
"""
