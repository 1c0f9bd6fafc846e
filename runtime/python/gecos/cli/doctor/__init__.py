"""`gecos doctor`: finds the reasons why programs cannot reach each other, and says how to correct
them.

Each module has checks of one kind. The module `readings` reads the values that the checks need, and
`examination` calls the checks with these values.
"""
