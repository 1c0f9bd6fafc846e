"""`gecos doctor`: finds the reasons why programs cannot reach each other, and says how to correct
them.

Each module has checks of one kind. A check is a function of values that it does not read itself:
`readings` reads the values, and `examination` calls the checks with them.
"""
