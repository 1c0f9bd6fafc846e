"""The command line of the compiler: a module for each verb, and what the verbs share."""
